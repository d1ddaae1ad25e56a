"""The page of a run in the browser, on viser (the extra ``view``)."""

from .page import Page as Page
from .server import PORT as PORT
