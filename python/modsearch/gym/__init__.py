"""The search for a design as environments of Gymnasium, one module per step."""

from .registration import register_environments

__all__ = ["register_environments"]
