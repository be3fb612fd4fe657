"""The nodes of a k-d tree, with the names of both trees of SciPy."""

from __future__ import annotations

from typing import Any, Optional, Protocol

import numpy as np
import numpy.typing as npt


class Points(Protocol):
    """The parts of a tree that its nodes read."""

    @property
    def _nodes(self) -> npt.NDArray[np.int64]: ...
    @property
    def indices(self) -> npt.NDArray[np.intp]: ...
    @property
    def data(self) -> npt.NDArray[np.float64]: ...


class Node:
    """A node of a tree: the points in a box.

    Attributes
    ----------
    level : int
        The number of nodes above this one.
    start_idx, end_idx : int
        The range of its points in ``KDTree.indices``.
    children : int
        The number of its points.
    indices, idx : array [children], intp
        The numbers of its points.
    data_points : array [children, m]
        Its points.
    split_dim : int
        The axis on which its halves are apart; -1 for a leaf.
    split : float
        The least coordinate of the upper half on that axis.
    lesser, less, greater : Node or None
        The halves; None for a leaf.
    """

    def __init__(self, tree: Optional[Points] = None, number: int = 0, level: int = 0) -> None:
        self._tree, self._number, self.level = tree, number, level
        self.start_idx, self.end_idx, self._right = (0, 0, 0) if tree is None else map(int, tree._nodes[number])
        self.split_dim, self.split = -1, 0.0
        self.lesser: Optional[Node] = None
        self.greater: Optional[Node] = None

    @property
    def children(self) -> int:
        return self.end_idx - self.start_idx

    @property
    def indices(self) -> npt.NDArray[np.intp]:
        return np.zeros(0, np.intp) if self._tree is None else self._tree.indices[self.start_idx : self.end_idx]

    @property
    def data_points(self) -> npt.NDArray[np.float64]:
        return np.zeros((0, 0)) if self._tree is None else self._tree.data[self.indices]

    @property
    def _node(self) -> Node:
        return self

    def _key(self) -> tuple[int, int, int]:
        return id(self._tree), self.level, self.start_idx

    def __lt__(self, other: Any) -> bool:
        return self._key() < other._key() if isinstance(other, Node) else NotImplemented

    def __gt__(self, other: Any) -> bool:
        return self._key() > other._key() if isinstance(other, Node) else NotImplemented

    def __le__(self, other: Any) -> bool:
        return self._key() <= other._key() if isinstance(other, Node) else NotImplemented

    def __ge__(self, other: Any) -> bool:
        return self._key() >= other._key() if isinstance(other, Node) else NotImplemented

    def __eq__(self, other: object) -> bool:
        return self._key() == other._key() if isinstance(other, Node) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._key())


class LeafNode(Node):
    """A node that has no halves."""

    @property
    def idx(self) -> npt.NDArray[np.intp]:
        return self.indices


class InnerNode(Node):
    """A node that has halves."""

    def __init__(self, tree: Points, number: int = 0, level: int = 0) -> None:
        super().__init__(tree, number, level)
        lesser, greater = node(tree, number + 1, level + 1), node(tree, self._right, level + 1)
        self.lesser, self.greater = lesser, greater
        extent = np.ptp(self.data_points, axis=0)
        # The last of equal extents, as the tree splits.
        self.split_dim = int(len(extent) - 1 - np.argmax(extent[::-1]))
        self.split = float(greater.data_points[:, self.split_dim].min())

    @property
    def less(self) -> Optional[Node]:
        return self.lesser


def node(tree: Points, number: int, level: int) -> Node:
    """A node of a tree, with all nodes below it."""
    return InnerNode(tree, number, level) if tree._nodes[number, 2] else LeafNode(tree, number, level)
