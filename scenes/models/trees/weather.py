"""The weather that trees grow and sway in: the season and the wind."""

from dataclasses import dataclass

SEASONS = ("spring", "summer", "autumn", "winter")


@dataclass(frozen=True)
class Weather:
    """season: one of SEASONS; wind: mean speed at the height of crowns [m/s], 0 = calm."""

    season: str = "summer"
    wind: float = 0.0


CALM_SUMMER = Weather()
