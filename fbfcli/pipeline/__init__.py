"""The one bridge between the rooms: the order of the steps, and what they carry from one part of a file to the next."""

from fbfcli.pipeline.compensate import Done, compensate
from fbfcli.pipeline.settings import Settings
from fbfcli.pipeline.summary import Summary

__all__ = ["Done", "Settings", "Summary", "compensate"]
