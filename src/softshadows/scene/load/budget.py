"""How much memory a file may ask for, in proportion to its size: what stops a small file from decoding to gigabytes."""

from __future__ import annotations

from dataclasses import dataclass

MEBIBYTE = 2**20


@dataclass
class Budget:
    """Bytes that may still be decoded."""

    left: int

    @classmethod
    def for_file(cls, size: int, *, floor_mebibytes: int, factor: int) -> Budget:
        """A fixed floor, so that small files may be well compressed, plus `factor` bytes for every byte of the file."""
        return cls(floor_mebibytes * MEBIBYTE + factor * size)

    def spend(self, size: int) -> bool:
        """Take `size` bytes, before an allocation whose size the file declares. False where fewer are left."""
        if size > self.left:
            return False
        self.left -= size
        return True
