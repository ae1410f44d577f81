"""The pinhole camera with OpenCV's lens distortion: points to pixels, and pixels to rays.

Coordinates are those of the camera's body frame: x forward along the optical axis, y to the left, z up. A pixel (u, v)
is a column, counted to the right, and a row, counted down. The centre of the first pixel is (0, 0), as in OpenCV: an
image covers −1/2 ≤ u < width − 1/2.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nao_kin._core.arrays import (
    Floats,
    as_floats,
    as_numbers,
    as_pixels,
    choice,
    first_index,
    positive,
    shaped,
    whole_number,
)
from nao_kin._core.text import one_line_repr, two_numbers
from nao_kin.errors import BadArgument, WrongShape
from nao_kin.robot import RobotModel
from nao_kin.robot.nao import RESOLUTIONS

# Newton's steps on the distortion, and the error of the result in normalised coordinates that counts as solved.
_MOST_STEPS, _SOLVED = 40, 1e-12
# Ratio of two singular values of the rays to the edge of a ball below which they determine no cone.
_OPEN = 1e-7
# Pixels are square within this share, beside the rounding of a size to whole pixels: two data sheets differ by less.
_SQUARE = 0.05
# The optical axis of a lens meets the image this near to its middle, as a share of its width and height.
_CENTRED = 0.12


@one_line_repr
@dataclass(frozen=True)
class Camera:
    """A camera: the frame that it is mounted at, the size of its image, its focal lengths, centre and distortion.

    A point (x, y, z) of the camera's body frame has the normalised coordinates a = −y/x to the right and b = −z/x down.
    With s = a² + b² the lens moves them to

        radial = (1 + k1 s + k2 s² + k3 s³) / (1 + k4 s + k5 s² + k6 s³),
        a' = a radial + 2 p1 a b + p2 (s + 2 a²),
        b' = b radial + p1 (s + 2 b²) + 2 p2 a b,

    and the pixel is u = cx + fx a', v = cy + fy b'.

    Attributes:
        name: name of the camera.
        frame: frame of the robot that the camera is mounted at: its body frame, with x along the optical axis, y to the
            left and z up, or its optical frame, with z along it and x to the right, from which the functions of
            `nk.world` and `nk.calibration` compute the body frame. A frame is optical if it is that of a camera of the
            robot's semantics, as CameraTop_optical_frame, or if its name ends in _optical or _optical_frame (REP 103).
        width, height: size of the image [pixel].
        fx, fy: focal lengths [pixel].
        cx, cy: where the optical axis meets the image [pixel].
        distortion: k1, k2, p1, p2[, k3[, k4, k5, k6]] in OpenCV's order; () for none. Zeros that follow, as in the 14
            numbers of OpenCV's rational model, are left out. The four numbers of its fisheye model mean something else.
        nominal: whether the lens is the published one, from which the lens of a single camera differs by about 3 %, and
            not a measured one. `nk.calibration.calibrate` then estimates it.

    Raises:
        BadArgument: a size or focal length that is not positive, or another number of coefficients.

    Source: OpenCV's documentation, Camera Calibration and 3D Reconstruction, detailed description.

    Examples:
        >>> camera = nk.world.Camera("mine", "CameraTop", 640, 480, 558.0, 560.0, 317.0, 243.0, (-0.1, 0.02, 0, 0))
        >>> pixel = camera.project([2.0, 0.3, -0.1])
        >>> pixel.round(1).tolist(), (2.0 * camera.ray(pixel) / camera.ray(pixel)[0]).round(9).tolist()
        ([233.5, 270.9], [2.0, 0.3, -0.1])
    """

    name: str
    frame: str
    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = ()
    nominal: bool = False

    def __post_init__(self) -> None:
        for name in ("width", "height"):
            object.__setattr__(self, name, whole_number(getattr(self, name), f"{name} of {self.name}", 1))
        for name in ("fx", "fy", "cx", "cy"):
            value, what = getattr(self, name), f"{name} of {self.name}"
            number = positive(value, what) if name in ("fx", "fy") else shaped(value, (), what)
            object.__setattr__(self, name, float(number))
        coefficients = as_floats(self.distortion, (), f"distortion of {self.name}").ravel()
        count = len(coefficients)
        if count in (12, 14) and not coefficients[8:].any():  # OpenCV's thin prism and tilted sensor
            coefficients = coefficients[:8]
        if len(coefficients) not in (0, 4, 5, 8):
            what = "0, 4, 5 or 8 coefficients k1, k2, p1, p2, k3, k4, k5, k6, and only zeros after them"
            more = f"got {count}: thin prisms and tilted sensors are not modelled"
            raise BadArgument(f"distortion of {self.name} must be {what}, {more}")
        object.__setattr__(self, "distortion", tuple(coefficients.tolist()))

    @staticmethod
    def from_matrix(matrix: ArrayLike, distortion: ArrayLike = (), *, frame: str, size: tuple[int, int]) -> Camera:
        """Return the camera of OpenCV's camera matrix and distortion coefficients, as `calibrateCamera` returns them.

        Args:
            matrix: [[fx, 0, cx], [0, fy, cy], [0, 0, 1]] [pixel].
            distortion: 0, 4, 5 or 8 coefficients, or 12 or 14 with zeros after the 8th, in an array of any shape.
            frame: the camera's body frame or optical frame on the robot, as the attribute.
            size: width and height of the images of the calibration [pixel]; a part of them is `cropped` from it.

        Raises:
            BadArgument: the matrix is not of this form, or of images of another size: (cx, cy) is farther from the
                middle of the image than 12 % of its width or height.

        Examples:
            >>> matrix = [[558.0, 0.0, 317.0], [0.0, 560.0, 243.0], [0.0, 0.0, 1.0]]
            >>> nk.world.Camera.from_matrix(matrix, frame="CameraTop", size=(640, 480)).fy
            560.0
        """
        K = shaped(matrix, (3, 3), "camera matrix")
        if K[0, 1] or K[1, 0] or K[2].tolist() != [0.0, 0.0, 1.0]:
            raise BadArgument("a camera matrix must be [[fx, 0, cx], [0, fy, cy], [0, 0, 1]]")
        width, height = _size(size)
        if abs(2.0 * K[0, 2] + 1.0 - width) > 2.0 * _CENTRED * width or (
            abs(2.0 * K[1, 2] + 1.0 - height) > 2.0 * _CENTRED * height
        ):
            likely = f"{round(2.0 * K[0, 2] + 1.0)} × {round(2.0 * K[1, 2] + 1.0)}"
            raise BadArgument(
                f"(cx, cy) = {pixel_name(K[:2, 2])} is not near the middle of an image of {width} × {height} pixels; "
                f"size is the width and height of the images of the calibration, about {likely}; "
                "resized and cropped give the camera of others"
            )
        return Camera(frame, frame, width, height, K[0, 0], K[1, 1], K[0, 2], K[1, 2], distortion)  # type: ignore[arg-type]

    def resized(self, size: tuple[int, int]) -> Camera:
        """Return the camera of images that are scaled to another size, as by OpenCV's `resize`.

        With the scales s_u and s_v of width and height, a pixel becomes (s_u (u + 1/2) − 1/2, s_v (v + 1/2) − 1/2),
        because the edges of the image correspond, and its first pixel has its centre at (0, 0). So fx' = s_u fx,
        cx' = s_u (cx + 1/2) − 1/2, and likewise fy' and cy'; the distortion remains.

        Args:
            size: width and height of the scaled images [pixel]; their shape may be another one.

        Raises:
            BadArgument: height and width are exchanged.

        Examples:
            >>> camera = nk.world.Camera("c", "CameraTop", 640, 480, 558.0, 560.0, 317.0, 243.0)
            >>> half = camera.resized((320, 240))
            >>> half.fx, half.fy, half.cx, half.cy
            (279.0, 280.0, 158.25, 121.25)
        """
        width, height = _size(size)
        if width != height and width * self.width == height * self.height:
            raise BadArgument(f"size is (width, height), as in ({height}, {width}), got ({width}, {height})")
        across, down = width / self.width, height / self.height
        cx, cy = across * (self.cx + 0.5) - 0.5, down * (self.cy + 0.5) - 0.5
        return replace(self, width=width, height=height, fx=across * self.fx, fy=down * self.fy, cx=cx, cy=cy)

    def cropped(self, corner: tuple[int, int], size: tuple[int, int]) -> Camera:
        """Return the camera of a part of its images; (cx, cy) moves by the corner.

        Args:
            corner: column and row of the part's first pixel, its upper left one.
            size: width and height of the part [pixel].

        Raises:
            BadArgument: the part extends beyond the image.

        Examples:
            >>> camera = nk.world.Camera("c", "CameraTop", 640, 480, 558.0, 560.0, 317.0, 243.0)
            >>> middle = camera.cropped((160, 120), (320, 240))
            >>> middle.width, middle.fx, middle.cx, middle.cy
            (320, 558.0, 157.0, 123.0)
        """
        (left, upper), (width, height) = (whole_number(at, "corner", 0) for at in corner), _size(size)
        if left + width > self.width or upper + height > self.height:
            part = f"{width} × {height} pixels from ({left}, {upper}) on"
            raise BadArgument(f"{part} extend beyond the image of {self.name}, {self.width} × {self.height} pixels")
        return replace(self, width=width, height=height, cx=self.cx - left, cy=self.cy - upper)

    @property
    def matrix(self) -> Floats:
        """OpenCV's camera matrix [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], shape (3, 3) [pixel]."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    def project(self, points: ArrayLike) -> Floats:
        """Return the pixels of points.

        A point has no pixel if it is not in front of the camera, or so far from the optical axis that the distortion is
        not invertible there: its polynomials send such points back into the image.

        Args:
            points: in the camera's body frame, shape (..., 3) [m].

        Returns:
            Pixels (u, v), shape (..., 2), inside the image or not; NaN in a batch for a point without pixel.

        Raises:
            BadArgument: a single point has no pixel.

        Examples:
            >>> camera = nk.world.camera(nk.load_nao(), "CameraTop")
            >>> camera.project([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]).tolist()
            [[319.5, 239.5], [nan, nan]]
        """
        p = as_floats(points, (3,), "points")
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            ab = np.where(p[..., :1] > 0.0, -p[..., 1:] / p[..., :1], np.nan)
            moved, J = self._distorted(ab)
            pixels = self._pixels(moved)
            bad = ~self._invertible(ab, J) | ~np.isfinite(pixels).all(axis=-1)
        pixels[bad] = np.nan
        if p.ndim == 1 and bad:
            behind = p[0] <= 0.0
            why = "is not in front of" if behind else "is too far from the optical axis for the distortion of"
            raise BadArgument(f"the point {why} {self.name}")
        return pixels

    def ray(self, pixels: ArrayLike) -> Floats:
        """Return the directions from which the light of pixels comes.

        The distortion is inverted by Newton's method, and each result is checked: the distortion must be invertible
        there, and lead to the pixel again.

        Args:
            pixels: (u, v), shape (..., 2), inside the image or not; NaN stays NaN.

        Returns:
            Unit vectors in the camera's body frame, shape (..., 3); NaN in a batch where the distortion is not
            invertible.

        Raises:
            BadArgument: the distortion cannot be inverted at a single pixel; the message names it.

        Examples:
            >>> camera = nk.world.camera(nk.load_nao(), "CameraTop")
            >>> camera.ray([319.5, 239.5]).tolist()
            [1.0, 0.0, 0.0]
        """
        ab = self.normalised(pixels)
        ray = np.empty((*ab.shape[:-1], 3))
        ray[..., 0] = 1.0
        np.subtract(0.0, ab, out=ray[..., 1:])
        ray /= np.sqrt(np.einsum("...i,...i->...", ray, ray))[..., None]
        return ray

    def normalised(self, pixels: ArrayLike) -> Floats:
        """Return the normalised coordinates a = −y/x, b = −z/x of pixels; arguments, NaN and errors as in `ray`.

        Examples:
            >>> nk.world.Camera("c", "f", 640, 480, 500, 500, 320, 240).normalised([820.0, 240.0]).tolist()
            [1.0, 0.0]
        """
        uv = as_pixels(pixels)
        ab = (uv - (self.cx, self.cy)) / (self.fx, self.fy)
        if not self.distortion:
            return ab
        found = self._undistorted(ab.reshape(-1, 2)).reshape(ab.shape)
        if uv.ndim == 1 and np.isnan(found).any() and np.isfinite(uv).all():
            raise BadArgument(f"the distortion of {self.name} cannot be inverted at the pixel {pixel_name(uv)}")
        return found

    def pixel_jacobian(self, points: ArrayLike) -> Floats:
        """Return the derivatives of the pixels of points with respect to the points.

        Args:
            points: in the camera's body frame, shape (..., 3) [m].

        Returns:
            ∂(u, v)/∂(x, y, z), shape (..., 2, 3) [pixel/m]; NaN for a point that is not in front of the camera.

        Examples:
            >>> camera = nk.world.Camera("c", "f", 640, 480, 500.0, 500.0, 320.0, 240.0)
            >>> camera.pixel_jacobian([2.0, 0.0, 0.0]).tolist()
            [[0.0, -250.0, 0.0], [0.0, 0.0, -250.0]]
        """
        p = as_floats(points, (3,), "points")
        x = np.where(p[..., 0] > 0.0, p[..., 0], np.nan)
        J = np.zeros((*x.shape, 2, 3))
        with np.errstate(all="ignore"):  # very near the camera they are infinite
            ab = -p[..., 1:] / x[..., None]
            J[..., :, 0] = -ab / x[..., None]
            J[..., 0, 1] = J[..., 1, 2] = -1.0 / x
            return np.asarray(self.lens_jacobian(ab) @ J)

    def lens_jacobian(self, normalised: Floats) -> Floats:
        """Return ∂(u, v)/∂(a, b) at normalised coordinates, shape (..., 2, 2) [pixel].

        Examples:
            >>> camera = nk.world.Camera("c", "f", 640, 480, 500.0, 510.0, 320.0, 240.0)
            >>> camera.lens_jacobian(np.zeros(2)).tolist()
            [[500.0, 0.0], [0.0, 510.0]]
        """
        ab = as_numbers(normalised, "normalised coordinates")
        if ab.shape[-1:] != (2,):
            raise WrongShape("normalised coordinates", "(..., 2)", ab.shape)
        return np.asarray(self._distorted(ab)[1] * np.array([[self.fx], [self.fy]]))

    def sees(self, pixels: ArrayLike) -> NDArray[np.bool_]:
        """Return whether pixels, shape (..., 2), are inside the image; NaN is not.

        Examples:
            >>> camera = nk.world.camera(nk.load_nao(), "CameraTop")
            >>> camera.sees([[0.0, 0.0], [640.0, 100.0], [np.nan, np.nan]]).tolist()
            [True, False, False]
        """
        uv = as_pixels(pixels)
        u, v = uv[..., 0], uv[..., 1]
        return np.asarray((u >= -0.5) & (u < self.width - 0.5) & (v >= -0.5) & (v < self.height - 0.5))

    def border(self, per_side: int = 1) -> Floats:
        """Return pixels along the edge of the image: from the upper left corner to the right and around.

        Args:
            per_side: pixels of each side, without the corner at its end.

        Returns:
            Shape (4 · per_side, 2).

        Examples:
            >>> nk.world.Camera("c", "f", 640, 480, 500, 500, 320, 240).border().tolist()
            [[-0.5, -0.5], [639.5, -0.5], [639.5, 479.5], [-0.5, 479.5]]
        """
        corners = np.array([[0, 0], [self.width, 0], [self.width, self.height], [0, self.height], [0, 0]]) - 0.5
        share = np.linspace(0.0, 1.0, whole_number(per_side, "per_side", 1), endpoint=False)[:, None]
        return np.asarray((corners[:-1, None] + share * np.diff(corners, axis=0)[:, None]).reshape(-1, 2))

    def ball_outline(self, centres: ArrayLike, radius: float, n: int = 32) -> Floats:
        """Return pixels on the edges of balls: where the cone from the camera touches them.

        A ball at the distance D appears as a cone of half-angle asin(radius/D) around its centre; off the optical axis
        its image is an ellipse, whose middle is not the pixel of the centre.

        Args:
            centres: in the camera's body frame, shape (..., 3) [m].
            radius: of the balls [m].
            n: pixels of each, at least three.

        Returns:
            Pixels, shape (..., n, 2), inside the image or not; NaN for those that `project` does not have.

        Raises:
            BadArgument: the camera is inside a ball.

        Examples:
            >>> camera = nk.world.Camera("c", "f", 640, 480, 500.0, 500.0, 320.0, 240.0)
            >>> np.ptp(camera.ball_outline([2.0, 0.0, 0.0], 0.05), axis=0).round(2).tolist()  # width and height
            [25.01, 25.01]
        """
        centre, size = as_floats(centres, (3,), "centres"), float(positive(radius, "radius"))
        count = whole_number(n, "n", 3)
        near = np.asarray(np.linalg.norm(centre, axis=-1) <= size)
        if near.any():
            raise BadArgument(f"{self.name} is inside the ball at {centre[first_index(near)].tolist()}")
        return self.project(tangent_circle(centre, size, count))

    def ball_centre(self, pixels: ArrayLike, radius: float) -> Floats:
        """Return the centres of balls of a known radius from pixels on their edges.

        The rays r of the edge are at one angle to the ray c of the centre, r·m = 1 with m = c/cos α. The least squares
        solution m gives the direction and the half-angle α, and the distance is radius/sin α.

        Args:
            pixels: at least three on the edge of each ball, shape (..., n, 2). For a circle that a detector found,
                centre + r (cos φ, sin φ) for a few angles φ.
            radius: of the balls [m].

        Returns:
            Centres in the camera's body frame, shape (..., 3) [m]; NaN in a batch if the pixels are on no cone.

        Raises:
            BadArgument: fewer than three pixels; those of a single ball are on no cone, or have no ray.

        Examples:
            >>> camera = nk.world.Camera("c", "f", 640, 480, 500.0, 500.0, 320.0, 240.0, (-0.1, 0.02, 0.0, 0.0))
            >>> edge = camera.ball_outline([2.0, 0.4, -0.3], 0.05, n=8)
            >>> camera.ball_centre(edge, 0.05).round(9).tolist()
            [2.0, 0.4, -0.3]
        """
        uv, size = as_pixels(pixels), float(positive(radius, "radius"))
        if uv.ndim < 2 or uv.shape[-2] < 3:
            raise WrongShape("pixels on the edge of a ball", "(..., n, 2) with n ≥ 3", uv.shape)
        rays = self.ray(uv)
        known = np.asarray(np.isfinite(rays).all(axis=(-2, -1)))
        U, sizes, Vt = np.linalg.svd(np.where(known[..., None, None], rays, 1.0), full_matrices=False)
        # Pixels on a line, or all the same, leave a component of m open.
        known &= (sizes[..., 2] > _OPEN * sizes[..., 1]) & (sizes[..., 1] > _OPEN * sizes[..., 0])
        with np.errstate(all="ignore"):
            found = np.einsum("...kj,...k->...j", Vt, U.sum(axis=-2) / sizes)
            length = np.linalg.norm(found, axis=-1)
            # sin² α = 1 − 1/‖m‖², and the centre is radius/sin α along m.
            centre = found * (size / np.sqrt((length - 1.0) * (length + 1.0)))[..., None]
        centre[~known | ~(length > 1.0)] = np.nan
        if centre.ndim == 1 and np.isnan(centre).any():
            raise BadArgument(f"the pixels are not those of the edge of a ball in the image of {self.name}")
        return np.asarray(centre)

    # --- The lens, in normalised coordinates.

    def _pixels(self, ab: Floats) -> Floats:
        return ab * (self.fx, self.fy) + (self.cx, self.cy)

    @functools.cached_property
    def _coefficients(self) -> tuple[float, ...]:
        return self.distortion + (0.0,) * (8 - len(self.distortion))

    @functools.cached_property
    def _fold(self) -> float:
        """The square of the radius up to which the radial distortion increases; infinite if it always does."""
        k1, k2, _, _, k3, k4, k5, k6 = self._coefficients
        N, D, even = np.array([k3, k2, k1, 1.0]), np.array([k6, k5, k4, 1.0]), np.array([6.0, 4.0, 2.0, 0.0])
        # The derivative of r N(r²)/D(r²) by r has the sign of (N + 2 s N') D − 2 s N D' in s = r². D has a pole at its
        # root.
        slope = np.convolve(N * (even + 1.0), D) - np.convolve(N, D * even)
        roots = [complex(root) for p in (slope, D) for root in np.roots(np.where(np.abs(p) > 1e-200, p, 0.0))]
        ends = [root.real for root in roots if abs(root.imag) < 1e-12 * (1 + abs(root))]
        return min((end for end in ends if end > 0.0), default=math.inf)

    def _invertible(self, ab: Floats, J: Floats) -> NDArray[np.bool_]:
        """Return where the distortion with the derivatives J does not fold the image: det J > 0, before the fold."""
        return np.asarray((_determinant(J) > 0.0) & ((ab * ab).sum(axis=-1) < self._fold))

    def _distorted(self, ab: Floats) -> tuple[Floats, Floats]:
        """Return distorted coordinates (..., 2) and their derivatives (..., 2, 2)."""
        J = np.empty((*ab.shape, 2))
        if not self.distortion:
            J[:] = np.eye(2)
            return ab, J
        k1, k2, p1, p2, k3, k4, k5, k6 = self._coefficients
        a, b = ab[..., 0], ab[..., 1]
        s, ab2 = a * a + b * b, 2.0 * a * b
        N, D = 1.0 + s * (k1 + s * (k2 + s * k3)), 1.0 + s * (k4 + s * (k5 + s * k6))
        radial = N / D
        # Twice the derivative of the radial factor by s, as ∂s/∂a = 2a.
        slope = 2.0 * ((k1 + s * (2.0 * k2 + s * 3.0 * k3)) - radial * (k4 + s * (2.0 * k5 + s * 3.0 * k6))) / D
        J[..., 0, 0] = radial + a * a * slope + 2.0 * p1 * b + 6.0 * p2 * a
        J[..., 1, 1] = radial + b * b * slope + 6.0 * p1 * b + 2.0 * p2 * a
        J[..., 0, 1] = J[..., 1, 0] = a * b * slope + 2.0 * (p1 * a + p2 * b)
        moved = np.empty(ab.shape)
        moved[..., 0] = a * radial + p1 * ab2 + p2 * (s + 2.0 * a * a)
        moved[..., 1] = b * radial + p1 * (s + 2.0 * b * b) + p2 * ab2
        return moved, J

    def _undistorted(self, wanted: Floats) -> Floats:
        """Return the coordinates whose distortion is `wanted`, shape (n, 2); NaN where there is none."""
        found = wanted.copy()
        left = np.arange(len(found))
        with np.errstate(all="ignore"):
            for _ in range(_MOST_STEPS):
                moved, J = self._distorted(found[left])
                error = moved - wanted[left]
                # J⁻¹ = (trace J − J) / det J
                step = J.trace(axis1=1, axis2=2)[:, None] * error - np.einsum("nij,nj->ni", J, error)
                ab = found[left] - step / _determinant(J)[:, None]
                # No step leaves the circle in which the distortion is invertible.
                over = np.sqrt((ab * ab).sum(axis=-1) / self._fold)
                found[left] = ab / np.maximum(1.0, over * (1.0 + 1e-9))[:, None]
                left = left[~(np.abs(error).max(axis=-1) < _SOLVED)]
                if not len(left):
                    break
            moved, J = self._distorted(found)
            fine = np.abs(moved - wanted).max(axis=-1) < 1e3 * _SOLVED * (1.0 + np.abs(wanted).max(axis=-1))
            fine &= self._invertible(found, J)
        found[~fine] = np.nan
        return np.asarray(found)


def _determinant(J: Floats) -> Floats:
    return np.asarray(J[..., 0, 0] * J[..., 1, 1] - J[..., 0, 1] * J[..., 1, 0])


def camera(robot: RobotModel, name: str, resolution: str | tuple[int, int] = "VGA") -> Camera:
    """Return a robot's camera with its measured lens, or else its published field of view, without distortion.

    A robot loaded with a file of `nk.calibration` may have a measured lens; other cameras are nominal. With the
    horizontal and vertical field of view α and β: fx = (width/2)/tan(α/2), fy = (height/2)/tan(β/2), and the
    optical axis meets the middle of the image, ((width − 1)/2, (height − 1)/2).

    Args:
        robot: any robot with `semantics.cameras` and `semantics.fields_of_view`.
        name: a camera's frame, such as "CameraTop".
        resolution: name, or width and height [pixel], also as in "640x480", the order opposite to the shape of an image
            in NumPy; an image of any size shows the whole field of view, and `Camera.cropped` gives a part of it. The
            names are those of `semantics.resolutions`, and for a robot without any NAOqi's, from "QQQQVGA" to "16VGA".

    Raises:
        UnknownName: the robot has no such camera, or the camera no such resolution.
        BadArgument: the field of view of the camera is not known; or an image of this size cannot show all of it, as
            its pixels would not be square (within 5 %).

    Examples:
        >>> camera = nk.world.camera(nk.load_nao(), "CameraBottom", "QVGA")
        >>> camera.width, camera.height, round(camera.fx, 2), camera.cx
        (320, 240, 299.03, 159.5)
    """
    semantics = robot.semantics
    choice(name, semantics.cameras, f"camera of {robot.name}")
    if name not in semantics.fields_of_view:
        raise BadArgument(f"the field of view of {name} is not known; give it in fields_of_view, or make a Camera")
    size = two_numbers(resolution) or resolution if isinstance(resolution, str) else resolution
    if isinstance(size, str):
        sizes = _resolutions(robot)
        size = sizes[choice(size, sizes, f"resolution of {name}")]
    width, height = _size(size)
    across, high = (math.tan(angle / 2.0) for angle in semantics.fields_of_view[name])
    shape = across / high
    known = (width, height) in semantics.resolutions.values()
    fits, fits_turned = (
        abs(w - h * shape) <= max(_SQUARE * w, 0.5 + 0.5 * shape) for w, h in ((width, height), (height, width))
    )
    if not (known or fits):
        whole = max(width, round(height * shape)), max(height, round(width / shape))
        whole = (height, width) if fits_turned else whole
        raise BadArgument(
            f"an image of {name} cannot be {width} × {height} pixels, expected (width, height) as in "
            f"{whole[0]} × {whole[1]}; Camera.cropped gives a part of an image"
        )
    if name in semantics.lenses:
        own_width, own_height, fx, fy, cx, cy, *more = semantics.lenses[name]
        own = Camera(name, name, int(own_width), int(own_height), fx, fy, cx, cy, tuple(more))
        return own.resized((width, height))
    centre = (width - 1) / 2.0, (height - 1) / 2.0
    return Camera(name, name, width, height, width / 2.0 / across, height / 2.0 / high, *centre, nominal=True)


def tangent_circle(centres: Floats, radius: float, n: int) -> Floats:
    """Return n points of the circles in which cones from the origin touch balls, shape (..., n, 3).

    At the distance D their middle is (1 − radius²/D²) of the way to the centre, and they have the radius
    √(1 − radius²/D²) radius.
    """
    squares = radius**2 / np.einsum("...i,...i->...", centres, centres)[..., None, None]
    # Two axes across the direction of the centre, from the axis of space that is least along it.
    least = np.eye(3)[np.abs(centres).argmin(axis=-1)]
    one = np.cross(centres, least)
    one /= np.linalg.norm(one, axis=-1, keepdims=True)
    other = np.cross(centres, one)
    other /= np.linalg.norm(other, axis=-1, keepdims=True)
    angles = 2.0 * np.pi / n * np.arange(n)[:, None]
    across = np.cos(angles) * one[..., None, :] + np.sin(angles) * other[..., None, :]
    return np.asarray((1.0 - squares) * centres[..., None, :] + radius * np.sqrt(1.0 - squares) * across)


def _size(size: tuple[int, int]) -> tuple[int, int]:
    width, height = size
    return whole_number(width, "width", 1), whole_number(height, "height", 1)


def outside_image(robot: RobotModel, camera: Camera, pixels: Floats) -> str:
    """Return a message on pixels (..., 2) outside the image, with the smallest resolution that contains them."""
    sizes = sorted(_resolutions(robot).items(), key=lambda item: item[1])
    name = next((f" ({name})" for name, size in sizes if size == (camera.width, camera.height)), "")
    last = pixels.reshape(-1, 2).max(axis=0) + 0.5
    fits = [f"{name}, {w} × {h}" for name, (w, h) in sizes if last[0] < w and last[1] < h and (pixels >= -0.5).all()]
    advice = f"contains {'it' if pixels.ndim == 1 else 'them'}: make the camera for the size of your images"
    more = f"; {fits[0]}, {advice}" if fits else ""
    return f"outside the image of {camera.name}, {camera.width} × {camera.height} pixels{name}{more}"


def _resolutions(robot: RobotModel) -> dict[str, tuple[int, int]]:
    return dict(robot.semantics.resolutions) or {row.name: (row.width, row.height) for row in RESOLUTIONS}


def pixel_name(pixel: Floats) -> str:
    """Return a pixel for a message."""
    return f"({pixel[0]:.6g}, {pixel[1]:.6g})"
