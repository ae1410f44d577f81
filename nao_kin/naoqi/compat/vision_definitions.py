"""The module `vision_definitions` that old scripts import: Aldebaran's numbers for cameras, images and parameters.

Source: Aldebaran documentation 2.5, ALVideoDevice, and vision_definitions.py of the Python SDK.
"""

from __future__ import annotations


def _numbered(names: str, suffix: str = "") -> dict[str, int]:
    """Return k and each name with a suffix, in order from 0; names that share a number are joined by "|"."""
    rows = enumerate(names.split())
    return {f"k{name}{suffix}": number for number, shared in rows for name in shared.split("|")}


_NUMBERS = {
    **_numbered("TopCamera BottomCamera DepthCamera"),
    **_numbered("QQVGA QVGA VGA 4VGA|960p 16VGA|1920p 720p 1080p QQQVGA QQQQVGA"),
    **_numbered(
        "Yuv yUv yuV Rgb rGb rgB Hsy|Hsv hSy|hSv hsY|hsV YUV422|YUV422Interlaced YUV RGB HSY|HSV BGR YYCbCr H2RGB "
        "HSMixed Depth ARGB XYZ Infrared Distance",
        "ColorSpace",
    ),
    "kRawDepthColorSpace": 23,
    **_numbered("SimpleScaleMethod AverageScaleMethod QualityScaleMethod NoScaling"),
    **_numbered(
        "CameraBrightness CameraContrast CameraSaturation CameraHue CameraRedChroma CameraBlueChroma CameraGain "
        "CameraHFlip CameraVFlip CameraLensX CameraLensY CameraAutoExposition CameraAutoWhiteBalance CameraAutoGain "
        "CameraResolution CameraFrameRate CameraBufferSize CameraExposure CameraSelect CameraSetDefaultParams "
        "CameraColorSpace CameraExposureCorrection CameraExposureAlgorithm|CameraAecAlgorithm CameraFastSwitch "
        "CameraSharpness CameraAwbGreenGain CameraAblc CameraAblcTarget CameraAblcStableRange CameraBlcBlue "
        "CameraBlcRed CameraBlcGb CameraBlcGr CameraWhiteBalance CameraBacklightCompensation CameraKeepAlive "
        "CameraDepthConfidenceThreshold CameraDepthFastFilter CameraTemperature CameraAverageLuminance CameraAutoFocus",
        "ID",
    ),
    # The models of the cameras.
    "kOV7670": 1,
    "kMT9M114": 2,
    "kOV5640": 3,
    "kXTION": 4,
}
globals().update(_NUMBERS)

__all__ = list(_NUMBERS)
