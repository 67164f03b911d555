"""Wishes for working views: limits of the arm, and a view that is chosen already."""

from __future__ import annotations

from dataclasses import dataclass

from ..parameter import check_parameters, parameter
from ..validation import InputError
from .arm import CRA_CAU, LAO_RAO, ArmLimits, ArmView, arm_limits
from .best import APART


def _angle(does: str, default: float | None, most: float, **more: object) -> float:
    bounds = {"unit": "degrees", "least": 0.0, "most": most}
    return parameter(does, default, **{**bounds, **more})


@dataclass(frozen=True)
class ViewWishes:
    """Degrees; `InputError` for angles that no arm has."""

    lao_rao: float = _angle(
        "how far the arm turns to either side", LAO_RAO, 180, option="lao-rao", called="LAO/RAO"
    )
    cra_cau: float = _angle("and to head and feet", CRA_CAU, 90, option="cra-cau", called="CRA/CAU")
    apart: float = _angle(
        "between best and second view, at least",
        APART,
        90,
        option="apart",
        called="angle between both views",
    )
    lao: float | None = _angle(
        "of a view that is told, too; RAO is negative", None, 180, least=-180.0, called="LAO"
    )
    cra: float | None = _angle("and CRA; CAU is negative", None, 90, least=-90.0, called="CRA")
    table: tuple[tuple[float, float, float], ...] = parameter(
        "rows of LAO, largest CRA and largest CAU there, which table and patient leave",
        default=(),
    )

    def __post_init__(self) -> None:
        check_parameters(self)
        _ = self.limits
        if (self.lao is None) != (self.cra is None):
            known, lacks = ("LAO", "CRA") if self.cra is None else ("CRA", "LAO")
            raise InputError(
                f"views: expected both angles of a view, got {known} alone; give {lacks}, too, "
                "or none."
            )

    @property
    def limits(self) -> ArmLimits:
        """The limits of the arm."""
        return arm_limits(self.lao_rao, self.cra_cau, self.table)

    @property
    def view(self) -> ArmView | None:
        """Chosen view, shown beside the proposed ones; None without both angles."""
        return None if self.lao is None or self.cra is None else ArmView(self.lao, self.cra)
