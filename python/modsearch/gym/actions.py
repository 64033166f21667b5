"""Three forms of one action: which module type comes next, and its parameters."""

from __future__ import annotations

from typing import Any, Literal, Protocol

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

Form = Literal["hybrid", "flat", "binned"]

Types = NDArray[np.int64]
Numbers = NDArray[np.float32]
Mask = NDArray[np.int8]


class Actions(Protocol):
    """What an agent gives, as the type k and the parameters x_k that it stands for, each in [-1, 1]."""

    @property
    def space(self) -> spaces.Space[Any]:
        """What an agent chooses from."""
        ...

    def decode(self, action: Any, mask: Mask) -> tuple[int, Numbers]:
        """One action; `mask` [K]: types that may follow."""
        ...

    def decode_batch(self, actions: Any, masks: Mask) -> tuple[Types, Numbers]:
        """[n] types and their parameters [n, P], P of the type that has most; `masks` [n, K]."""
        ...

    def masks(self, mask: Mask) -> NDArray[np.bool_]:
        """What may be chosen [.., number of discrete choices], for MaskablePPO and its like."""
        ...


class Hybrid:
    """Tuple(Discrete(K), Tuple(Box_1, .., Box_K)): the type, and parameters for every type, of which those of the type
    count. A type without parameters has a Box of shape (0,)."""

    def __init__(self, counts: list[int]) -> None:
        boxes = [spaces.Box(-1.0, 1.0, (n,), np.float32) for n in counts]
        self.space = spaces.Tuple((spaces.Discrete(len(counts)), spaces.Tuple(boxes)))
        self._most = max(counts)

    def decode(self, action: Any, mask: Mask) -> tuple[int, Numbers]:
        k = int(action[0])
        if not 0 <= k < len(mask):
            raise ValueError(f"action {k}: not in [0, {len(mask)})")
        return k, np.ascontiguousarray(action[1][k], np.float32)

    def decode_batch(self, actions: Any, masks: Mask) -> tuple[Types, Numbers]:
        types = np.ascontiguousarray(actions[0], np.int64)
        slots = np.zeros((len(types), self._most), np.float32)
        for k, box in enumerate(actions[1]):
            chosen = types == k
            if box.shape[1] and chosen.any():
                slots[chosen, : box.shape[1]] = box[chosen]
        return types, slots

    def masks(self, mask: Mask) -> NDArray[np.bool_]:
        return mask.astype(np.bool_)


class Flat:
    """One Box [K + D]: a preference for each type, of which the greatest among those that may follow is taken, and the
    parameters of all types one after the other. For agents that know nothing but a Box; no action is masked."""

    def __init__(self, counts: list[int]) -> None:
        self._n_types = len(counts)
        self._counts = counts
        self._offsets = np.concatenate([[0], np.cumsum(counts)])[:-1] + self._n_types
        self.space = spaces.Box(-1.0, 1.0, (self._n_types + sum(counts),), np.float32)
        # Where in an action the parameters of a type stand; what a type does not have is taken from anywhere.
        slots = np.arange(max(counts))
        self._places = np.minimum(self._offsets[:, None] + slots[None, :], self.space.shape[0] - 1)

    def decode(self, action: Any, mask: Mask) -> tuple[int, Numbers]:
        action = np.asarray(action, np.float32)
        k = int(np.argmax(np.where(mask != 0, action[: self._n_types], -np.inf)))
        offset = self._offsets[k]
        return k, np.ascontiguousarray(action[offset : offset + self._counts[k]])

    def decode_batch(self, actions: Any, masks: Mask) -> tuple[Types, Numbers]:
        actions = np.asarray(actions, np.float32)
        types = np.argmax(np.where(masks != 0, actions[:, : self._n_types], -np.inf), axis=1)
        return types, np.ascontiguousarray(np.take_along_axis(actions, self._places[types], axis=1))

    def masks(self, mask: Mask) -> NDArray[np.bool_]:
        return mask.astype(np.bool_)


class Binned:
    """MultiDiscrete([K, B, .., B]): the type, and for each parameter one of B values evenly spread over its interval,
    as many as the type with most parameters has. The parameters of all types share these places."""

    def __init__(self, counts: list[int], bins: int) -> None:
        if bins < 2:
            raise ValueError(f"bins is {bins}, at least 2 are needed")
        self._most = max(counts)
        self._values = np.linspace(-1.0, 1.0, bins, dtype=np.float32)
        self.space = spaces.MultiDiscrete([len(counts)] + [bins] * self._most)
        self._free = np.ones(bins * self._most, np.bool_)

    def decode(self, action: Any, mask: Mask) -> tuple[int, Numbers]:
        return int(action[0]), self._values[np.asarray(action[1:], np.int64)]

    def decode_batch(self, actions: Any, masks: Mask) -> tuple[Types, Numbers]:
        actions = np.asarray(actions, np.int64)
        return np.ascontiguousarray(actions[:, 0]), self._values[actions[:, 1:]]

    def masks(self, mask: Mask) -> NDArray[np.bool_]:
        free = np.broadcast_to(self._free, (*mask.shape[:-1], len(self._free)))
        return np.concatenate([mask.astype(np.bool_), free], axis=-1)


def actions_of(form: Form, counts: list[int], bins: int) -> Actions:
    """`counts`: number of parameters of each type. Raises ValueError for a form that is none."""
    if form == "hybrid":
        return Hybrid(counts)
    if form == "flat":
        return Flat(counts)
    if form == "binned":
        return Binned(counts, bins)
    raise ValueError(f"actions: {form!r} is not one of hybrid, flat, binned")
