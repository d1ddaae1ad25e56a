"""PNG images (ISO/IEC 15948)."""

import struct
import zlib
from pathlib import Path

import numpy as np

_SIGNATURE = b"\x89PNG\r\n\x1a\n"


def png(pixels: np.ndarray) -> bytes:
    """Encode an image as PNG.

    Args:
        pixels: Red, green and blue from 0 to 255, the top row first.  # (height, width, 3)

    Raises:
        ValueError: If the shape or type is another.
    """
    if pixels.ndim != 3 or pixels.shape[2] != 3 or pixels.dtype != np.uint8 or not pixels.size:
        raise ValueError(f"expected (height, width, 3) of uint8, got {pixels.shape} {pixels.dtype}")
    height, width, _ = pixels.shape
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)  # 8 bits, true colour
    data = zlib.compress(_filtered(pixels), 9)
    return _SIGNATURE + _chunk(b"IHDR", header) + _chunk(b"IDAT", data) + _chunk(b"IEND", b"")


def write_png(path: str | Path, pixels: np.ndarray) -> None:
    """Write an image to a PNG file.

    Args:
        path: The file.
        pixels: Red, green and blue from 0 to 255, the top row first.  # (height, width, 3)
    """
    Path(path).write_bytes(png(pixels))


def _filtered(pixels: np.ndarray) -> bytes:
    """Filter each row so that its sum of absolute values is minimal, for compression."""
    height, width, _ = pixels.shape
    padded = np.zeros((height + 1, width + 1, 3), dtype=np.int16)
    padded[1:, 1:] = pixels
    here, left, up, corner = padded[1:, 1:], padded[1:, :-1], padded[:-1, 1:], padded[:-1, :-1]
    guess = left + up - corner
    a, b, c = (np.abs(guess - near) for near in (left, up, corner))
    paeth = np.where((a <= b) & (a <= c), left, np.where(b <= c, up, corner))
    kinds = np.stack([here, here - left, here - up, here - (left + up) // 2, here - paeth])
    rows = kinds.astype(np.uint8).reshape(5, height, 3 * width)  # modulo 256
    best = np.abs(rows.astype(np.int8).astype(np.int16)).sum(axis=2).argmin(axis=0)
    chosen = rows[best, np.arange(height)]
    return np.hstack([best.astype(np.uint8)[:, None], chosen]).tobytes()


def _chunk(kind: bytes, data: bytes) -> bytes:
    checksum = zlib.crc32(kind + data)
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", checksum)
