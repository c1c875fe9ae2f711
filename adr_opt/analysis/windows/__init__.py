"""Capture windows of targets, from sunlight, the Sun's angle and ground contacts."""

from .conditions import CaptureConditions, windows_of
from .stations import STATIONS, GroundStation, read_stations

__all__ = ["STATIONS", "CaptureConditions", "GroundStation", "read_stations", "windows_of"]
