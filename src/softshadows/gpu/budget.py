"""What one submit may hold: all that exists because drivers stop work that takes long.

The speeds are rough, measured on a two-core software rasteriser and assumed low for GPUs. They only decide how a long
frame is cut into submits, so that none of them runs into a driver's watchdog; no picture depends on them. What shaders
carry for drivers is in driver.wgsl and interleaved.wgsl.
"""

from __future__ import annotations

from dataclasses import dataclass

from softshadows.gpu.compose import constant

SUBMIT_MS = 500.0
"""What one submit may take, after those speeds. Browsers and drivers stop work after 2 to 30 seconds."""

ROUNDS_OF_DISPATCH = 50_000
"""Rounds of loops that an invocation may count in a dispatch, below the 65 535 that llvmpipe allows (driver.wgsl)."""

INTERLEAVED = constant("gpu/interleaved.wgsl", "INTERLEAVED")


def interleaved_groups(size: tuple[int, int], group: int = 8) -> tuple[int, int]:
    """Workgroups of `group`² pixels over an image, for shaders that take their rows by interleaved_row()."""
    width, height = size
    return -(-width // group), -(-height // (group * INTERLEAVED)) * INTERLEAVED


@dataclass(frozen=True)
class Budget:
    """Triangles drawn, map look-ups and rays in a millisecond, and the rays of a pixel that one dispatch may trace."""

    triangles_per_ms: int
    lookups_per_ms: int
    rays_per_ms: int
    rays_at_once: int


SOFTWARE = Budget(triangles_per_ms=10_000, lookups_per_ms=50_000, rays_per_ms=5_000, rays_at_once=16)
"""64 rays through a wheel's spokes have exceeded the rounds of loops that llvmpipe allows (driver.wgsl)."""

HARDWARE = Budget(triangles_per_ms=500_000, lookups_per_ms=10_000_000, rays_per_ms=200_000, rays_at_once=32)
