"""Checks that an environment, or a user's wrapper around one, keeps the promises of the task."""

from ucon.envs.checking.findings import Finding
from ucon.envs.checking.run import check
from ucon.envs.checking.subject import Subject, subject_of

__all__ = ["Finding", "Subject", "check", "subject_of"]
