"""What the tests share."""

from tests.support.drawing import opengl as opengl
