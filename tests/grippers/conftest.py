"""The Panda over a cube on a post, as in the tests of control."""

from tests.control.conftest import grip as grip
