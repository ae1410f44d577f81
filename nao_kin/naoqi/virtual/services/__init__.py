"""The services by name: those of the other files, and those that only refuse."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nao_kin._core.text import quoted
from nao_kin.naoqi.virtual.engine import NaoqiError
from nao_kin.naoqi.virtual.service import Service
from nao_kin.naoqi.virtual.services.expression import ALLeds, ALTextToSpeech
from nao_kin.naoqi.virtual.services.life import (
    ABILITIES,
    ALAutonomousLife,
    ALBattery,
    ALPreferenceManager,
    ALRobotModel,
    ALSystem,
)
from nao_kin.naoqi.virtual.services.memory import ALMemory, ALSonar, ALTouch
from nao_kin.naoqi.virtual.services.motion import ALMotion
from nao_kin.naoqi.virtual.services.movements import ALAnimationPlayer, ALBehaviorManager, ALRobotPosture, ALTracker

if TYPE_CHECKING:
    from nao_kin.naoqi.virtual.virtual_nao import VirtualNao


# The methods of every extractor of NAOqi.
_EXTRACTOR = (
    "subscribe unsubscribe getSubscribersInfo getOutputNames getEventList getMemoryKeyList updatePeriod "
    "updatePrecision pause isPaused isProcessing "
)

# Reason → missing services, and their methods in NAOqi 1.14 to 2.8.
_MISSING: dict[str, dict[str, str]] = {
    "its cameras give no pictures": {
        "ALVideoDevice": "subscribe subscribeCamera subscribeCameras unsubscribe unsubscribeAllInstances "
        "getImageRemote getImagesRemote getImageLocal getDirectRawImageRemote releaseImage getCameraIndexes "
        "getCameraName getActiveCamera setActiveCamera openCamera closeCamera isCameraOpen setParam getParam "
        "setParameter getParameter setAllParametersToDefault getResolution setResolution getFrameRate setFrameRate "
        "getColorSpace setColorSpace getAngularPositionFromImagePosition getImagePositionFromAngularPosition",
        "ALVideoRecorder": "startRecording stopRecording isRecording setCameraID setColorSpace setFrameRate "
        "setResolution setVideoFormat getCameraID getFrameRate getResolution getVideoFormat",
        "ALPhotoCapture": "takePicture takePictures halfPress isHalfPressed setCameraID setColorSpace setPictureFormat "
        "setResolution setCaptureInterval setHalfPressEnabled getCameraID getPictureFormat getResolution",
        "ALBarcodeReader": _EXTRACTOR,
        "ALBacklightingDetection": _EXTRACTOR,
        "ALCloseObjectDetection": _EXTRACTOR,
        "ALColorBlobDetection": f"{_EXTRACTOR} setColor setObjectProperties setActiveCamera setResolution setFrameRate",
        "ALDarknessDetection": f"{_EXTRACTOR} getDarknessThreshold setDarknessThreshold",
        "ALLandMarkDetection": f"{_EXTRACTOR} setActiveCamera setFrameRate setResolution setParameter",
        "ALLocalization": "learnHome goToHome goToPosition getRobotPosition getRobotOrientation load save",
        "ALMovementDetection": f"{_EXTRACTOR} setColorSensitivity setDepthSensitivity resetDetection",
        "ALRedBallDetection": f"{_EXTRACTOR} setActiveCamera setFrameRate setResolution",
        "ALRedBallTracker": "startTracker stopTracker isActive isNewData getPosition setWholeBodyOn",
        "ALVisionRecognition": f"{_EXTRACTOR} changeDatabase clearCurrentDatabase learnFromFile setMaxOutObjs setParam",
        "ALVisualCompass": f"{_EXTRACTOR} moveTo moveStraightTo setCurrentImageAsReference enableReferenceRefresh",
        "ALVisualSpaceHistory": _EXTRACTOR,
    },
    "it sees no people": {
        "ALEngagementZones": f"{_EXTRACTOR} setFirstLimitDistance setSecondLimitDistance setLimitAngle",
        "ALFaceCharacteristics": f"{_EXTRACTOR} analyzeFaceCharacteristics setSmileThreshold",
        "ALFaceDetection": f"{_EXTRACTOR} learnFace reLearnFace forgetPerson clearDatabase getLearnedFacesList "
        "importFolder setRecognitionEnabled isRecognitionEnabled setTrackingEnabled isTrackingEnabled "
        "enableRecognition enableTracking setParameter setActiveCamera setRecognitionConfidenceThreshold",
        "ALFaceTracker": "startTracker stopTracker isActive isNewData getPosition setWholeBodyOn",
        "ALGazeAnalysis": f"{_EXTRACTOR} getTolerance setTolerance",
        "ALPeoplePerception": f"{_EXTRACTOR} resetPopulation setMaximumDetectionRange getMaximumDetectionRange "
        "setTimeBeforePersonDisappears setFaceDetectionEnabled setMovementDetectionEnabled setFastModeEnabled",
        "ALSittingPeopleDetection": _EXTRACTOR,
        "ALUserSession": "getFocusedUser getOpenUserSessions getUserList doUserSessionsExist findUsersWithData",
        "ALWavingDetection": f"{_EXTRACTOR} setMaxDistance setMinSize",
    },
    "it hears nothing": {
        "ALAudioRecorder": "startMicrophonesRecording stopMicrophonesRecording recordVideo",
        "ALAudioSourceLocalization": _EXTRACTOR,
        "ALDialog": f"{_EXTRACTOR} loadTopic loadTopicContent unloadTopic activateTopic deactivateTopic setLanguage "
        "getAllLoadedTopics getLoadedTopics getActivatedTopics setFocus setConcept addToConcept gotoTag gotoTopic "
        "forceInput forceOutput tell insertUserData getUserData openSession closeSession resetAll runDialog stopDialog",
        "ALSoundDetection": f"{_EXTRACTOR} setParameter",
        "ALSoundLocalization": f"{_EXTRACTOR} setParameter",
        "ALSpeechRecognition": f"{_EXTRACTOR} setVocabulary setWordListAsVocabulary setLanguage getLanguage "
        "getAvailableLanguages setAudioExpression setVisualExpression setParameter getParameter compile loadVocabulary "
        "addContext removeContext removeAllContext pushContexts popContexts activateRule deactivateRule",
        "ALVoiceEmotionAnalysis": _EXTRACTOR,
    },
    "it makes no sound; ALTextToSpeech shows words": {
        "ALAnimatedSpeech": "say setBodyLanguageMode getBodyLanguageMode setBodyLanguageModeFromStr setBodyTalkEnabled "
        "isBodyTalkEnabled setBodyLanguageEnabled isBodyLanguageEnabled addTagsToWords declareAnimationsPackage "
        "declareTagForAnimations",
        "ALAudioDevice": "subscribe unsubscribe setClientPreferences setOutputVolume getOutputVolume muteAudioOut "
        "isAudioOutMuted enableEnergyComputation disableEnergyComputation getFrontMicEnergy getLeftMicEnergy "
        "getRearMicEnergy getRightMicEnergy openAudioInputs closeAudioInputs openAudioOutputs closeAudioOutputs "
        "startMicrophonesRecording stopMicrophonesRecording playSine setParameter getParameter",
        "ALAudioPlayer": "play playFile playFileInLoop playFileFromPosition playInLoop playSine playWebStream loadFile "
        "unloadFile unloadAllFiles pause stop stopAll goTo setVolume getVolume setMasterVolume getMasterVolume "
        "setPanorama getCurrentPosition getFileLength getLoadedFilesIds getLoadedFilesNames playSoundSetFile",
    },
    "a NAO has no such part": {
        "ALLaser": "laserON laserOFF setDetectingLength setOpeningAngle",
        "ALTabletService": "showWebview hideWebview loadUrl reloadPage loadApplication showImage showImageNoCache "
        "preLoadImage hideImage resumeGif pauseGif playVideo pauseVideo resumeVideo stopVideo setBackgroundColor "
        "executeJS showInputDialog showInputTextDialog hideDialog cleanWebview configureWifi getWifiStatus "
        "setBrightness getBrightness setVolume robotIp turnScreenOn wakeUp goToSleep resetTablet",
    },
    "it has no electronics; ALMotion moves its joints, and ALMemory has its values": {
        "ALFsr": _EXTRACTOR,
        "ALInfrared": "confRemoteRecordAddKey confRemoteRecordNext initReception sendRC5 sendRemoteKey subscribe",
        "ALSensors": f"{_EXTRACTOR} run",
        "DCM": "set setAlias createAlias getTime getPrefix special calibration preferences",
    },
    "it sees no obstacles; ALMotion walks without looking": {
        "ALNavigation": "navigateTo moveTo move moveAlong stop explore stopExploration startLocalization "
        "stopLocalization relocalizeInMap navigateToInMap getRobotPositionInMap loadExploration saveExploration "
        "startFreeZoneUpdate findFreeZone setSecurityDistance getSecurityDistance",
        "ALRecharge": "goToStation leaveStation lookForStation moveInFrontOfStation dockOnStation getStationPosition",
    },
    "it is not a separate computer": {
        "ALBodyTemperature": "areNotificationsEnabled setEnableNotifications getTemperatureDiagnosis",
        "ALDiagnosis": "getActiveDiagnosis getPassiveDiagnosis getDiagnosis isDiagnosisActive setEnableNotification",
        "ALFileManager": "fileExists getFileCompleteName getFileContents saveFile setUserSharedFolderPath",
        "ALConnectionManager": "scan services service connect disconnect forget state setServiceInput",
        "ALNotificationManager": "add remove notification notifications",
        "ALStore": "update getCurrentApplications",
        "PackageManager": "install installed packages package remove removePkg hasPackage",
    },
}


class Missing(Service):
    """A service that this virtual NAO does not have."""

    def __init__(self, nao: VirtualNao, name: str, why: str, methods: str) -> None:
        super().__init__(nao)
        self.name, self._why = name, why
        self._methods, self.absent = {}, tuple(dict.fromkeys(methods.split()))

    def _no_method(self, name: str) -> NaoqiError:
        others = ", ".join(other for other, service in self.nao.services.items() if not isinstance(service, Missing))
        return NaoqiError(self.name, quoted(name)[1:-1], f"not in this virtual NAO: {self._why}; there are: {others}")


SERVICES: tuple[type[Service], ...] = (
    ALMotion,
    ALRobotPosture,
    ALMemory,
    ALLeds,
    ALTextToSpeech,
    ALAutonomousLife,
    ALSystem,
    ALBattery,
    ALPreferenceManager,
    ALTouch,
    ALSonar,
    ALRobotModel,
    ALTracker,
    ALBehaviorManager,
    ALAnimationPlayer,
    *ABILITIES,
)


def make_services(nao: VirtualNao) -> dict[str, Service]:
    """Every service by its name, missing ones last."""
    found: dict[str, Service] = {kind.name: kind(nao) for kind in SERVICES}
    for why, services in _MISSING.items():
        found |= {name: Missing(nao, name, why, methods) for name, methods in services.items()}
    return found
