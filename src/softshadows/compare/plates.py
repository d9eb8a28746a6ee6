"""The pictures that a report shows of each technique: picture, visibility, truth, error."""

from __future__ import annotations

from softshadows import metrics
from softshadows.compare.measure import Measurement
from softshadows.compare.pictures import png

AMPLIFICATION = 5.0

Plates = list[tuple[str, bytes]]
"""Captions and PNG files, in the order in which they are shown."""


def plates(measurement: Measurement) -> dict[str, Plates]:
    """By technique label: its picture, the picture with true shadows, then per light visibility, truth and error."""
    reference = measurement.reference
    lights = len(measurement.shot.scene.lights)
    true_picture = png(reference.picture)
    truths = [png(truth) for truth in reference.visibility]
    shown: dict[str, Plates] = {}
    for result in measurement.results:
        made: Plates = [("picture", png(result.picture)), ("picture with true shadows", true_picture)]
        for light, (visibility, truth) in enumerate(zip(result.visibility, reference.visibility, strict=True)):
            of = f" of light {light}" if lights > 1 else ""
            error = metrics.signed_error_image(visibility, truth, reference.mask[light], amplification=AMPLIFICATION)
            made.append((f"visibility{of}", png(visibility)))
            made.append((f"truth{of}", truths[light]))
            made.append((f"error{of}", png(error)))
        shown[result.label] = made
    return shown


def explanation() -> str:
    """How to read the error maps, in one sentence."""
    return (
        "Error maps: white is no error, orange too light, blue too dark, full colour at an error of "
        f"{1.0 / AMPLIFICATION:g}; grey pixels show no surface or do not face the light, and count in no figure."
    )
