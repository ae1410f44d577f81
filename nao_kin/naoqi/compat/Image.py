"""The module `Image` that old scripts import for the pictures of ALVideoDevice: that of PIL 1.1.7, now in Pillow."""

from PIL.Image import *  # noqa: F403
from PIL.Image import frombytes

fromstring = frombytes
