"""The names under which Gymnasium makes the environments."""

from __future__ import annotations

VARIANTS = {
    "modsearch/Design-v0": "hybrid",
    "modsearch/Design-Flat-v0": "flat",
    "modsearch/Design-Binned-v0": "binned",
}


def register_environments() -> None:
    """Registers the environments with Gymnasium, where it is installed."""
    try:
        import gymnasium
    except ImportError:
        return
    for name, actions in VARIANTS.items():
        if name in gymnasium.registry:
            continue
        gymnasium.register(
            name,
            entry_point="modsearch.gym.env:DesignEnv",
            vector_entry_point="modsearch.gym.vector_env:DesignVectorEnv",
            kwargs={"actions": actions},
        )
