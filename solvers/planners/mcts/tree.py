"""The search tree in preallocated arrays, and simulations of one step."""

import math
from typing import NamedTuple

import numpy as np

from adr_opt.kernels.core.compile import inlined, kernel
from adr_opt.kernels.core.memory import borrowed, write
from adr_opt.kernels.rules import resources as resource_kernels
from adr_opt.kernels.rules import rules as rule_kernels
from adr_opt.kernels.rules.resources import Resources
from adr_opt.kernels.rules.rules import State

from . import policy as policies

NONE = -1
NOT_LISTED = -1


class Tree(NamedTuple):
    """Nodes by number, each with the state after its move.

    Attributes
    ----------
    body : (nodes,) int32
    resources : Resources
        Of the node, (nodes,) each.
    spent : (nodes,) float64
        ΔV spent since the start of the mission [m/s].
    visits, total, best : (nodes,) float64
        Number, sum and maximum of the returns of the simulations through the node.
    child, sibling : (nodes,) int32
        First child and next sibling.
    untried : (nodes,) int32
        Number of moves without a child; ``NOT_LISTED`` before the first is asked for.
    moves : (nodes, width) int32
        Those moves.
    """

    body: np.ndarray
    resources: Resources
    spent: np.ndarray
    visits: np.ndarray
    total: np.ndarray
    best: np.ndarray
    child: np.ndarray
    sibling: np.ndarray
    untried: np.ndarray
    moves: np.ndarray


class TreeSearch(NamedTuple):
    """Parameters of the tree search.

    Attributes
    ----------
    simulations : int
    c : float
        Exploration constant of UCT.
    guarded : bool
        Branch on the cheapest safe moves only.
    width : int
        How many targets, if so.
    by_range : bool
        Scale returns to the range seen so far before c counts.
    best_share : float
        Weight of the best return of a node against the mean.
    by_value : bool
        Play the child of highest value instead of the most visited.
    keep : bool
        Go on in the same tree after a move, instead of a new one.
    """

    simulations: int
    c: float
    guarded: bool
    width: int
    by_range: bool
    best_share: float
    by_value: bool
    keep: bool


class SearchRecord(NamedTuple):
    """Statistics of a mission's simulations.

    Attributes
    ----------
    sequence : (moves,) int64
        The best sequence.
    best : (3,) float64
        Its number of moves, its prizes, its ΔV [m/s].
    returns : (2,) float64
        Least and greatest return since the start.
    """

    sequence: np.ndarray
    best: np.ndarray
    returns: np.ndarray


class Game(NamedTuple):
    """A mission as played so far.

    Attributes
    ----------
    root : int
        The node where it is.
    used : int
        Nodes in use.
    played : int
        Moves before the root; they stand at the beginning of the sequence to work in.
    collected : float
        Their prizes.
    visited : (bodies,) bool
        Targets visited there.
    """

    root: int
    used: int
    played: int
    collected: float
    visited: np.ndarray


def allocate(nodes: int, width: int) -> Tree:
    """Storage for a tree; nodes are written on creation."""

    def integers() -> np.ndarray:
        return np.empty(nodes, dtype=np.int32)

    def numbers() -> np.ndarray:
        return np.empty(nodes)

    return Tree(
        integers(),
        resource_kernels.columns(nodes),
        numbers(),
        numbers(),
        numbers(),
        numbers(),
        integers(),
        integers(),
        integers(),
        np.empty((nodes, width), dtype=np.int32),
    )


def new_record(bodies: int) -> SearchRecord:
    """Empty statistics."""
    return SearchRecord(
        np.zeros(2 * bodies, dtype=np.int64),
        np.array([0.0, -math.inf, math.inf]),
        np.array([math.inf, -math.inf]),
    )


@inlined
def _state_at(tree, node):
    """The state after the move of a node."""
    return State(np.int64(tree.body[node]), resource_kernels.at(tree.resources, node))


@kernel
def write_node(tree, node, state, spent):
    """Create a node without children and simulations."""
    tree = borrowed(tree)
    tree.body[node], tree.spent[node] = state.body, spent
    resource_kernels.put(tree.resources, node, state.resources)
    tree.visits[node], tree.total[node], tree.best[node] = 0.0, 0.0, -math.inf
    tree.child[node], tree.sibling[node] = NONE, NONE
    tree.untried[node] = NOT_LISTED


@kernel
def copy_root(tree, node):
    """Restart the tree at the state of one of its nodes; returns the number of nodes in use: 1."""
    write_node(tree, 0, _state_at(tree, node), tree.spent[node])
    return 1


@kernel
def list_moves(rules, policy, search, tree, node, scratch):
    """List the moves of a node: all that may be legal, or the cheapest safe ones."""
    rules, tree, scratch = borrowed(rules), borrowed(tree), borrowed(scratch)
    state, moves = _state_at(tree, node), tree.moves[node]
    if search.guarded:
        tree.untried[node] = policies.cheapest_moves(
            rules, policy, state, scratch.visited, search.width, moves, scratch.weight
        )
        return
    count = 0
    for j in range(rules.service.size):
        if rule_kernels.may_go(rules, state, scratch.visited, j):
            moves[count] = j
            count += 1
    tree.untried[node] = count


@kernel
def expand(rules, search, rng, tree, node, used):
    """Add a child to a node, if an untried move is legal.

    Returns
    -------
    child : int
        ``NONE`` if every legal move has one.
    """
    rules, tree = borrowed(rules), borrowed(tree)
    moves, state = tree.moves[node], _state_at(tree, node)
    while tree.untried[node] > 0:
        tree.untried[node] -= 1
        last = tree.untried[node]
        j = moves[last]
        if not search.guarded:
            place = int(rng.random() * (last + 1))
            j = moves[place]
            moves[place] = moves[last]
        legal, delta_v, after = rule_kernels.step(rules, state, np.int64(j))
        if legal:
            write_node(tree, used, after, tree.spent[node] + delta_v)
            tree.sibling[used] = tree.child[node]
            tree.child[node] = used
            return used
    return NONE


@inlined
def value_of(search, tree, node):
    """Q: mean return of a node's simulations, or a mix of mean and best."""
    mean = tree.total[node] / tree.visits[node]
    return mean + search.best_share * (tree.best[node] - mean)


@kernel
def select(search, tree, node, record):
    """Child with the greatest Q + c sqrt(ln N / n); ``NONE`` without children."""
    tree = borrowed(tree)
    child = tree.child[node]
    if child == NONE:
        return NONE
    scale = 1.0
    if search.by_range and record.returns[1] > record.returns[0]:
        scale = 1.0 / (record.returns[1] - record.returns[0])
    logarithm = math.log(tree.visits[node])
    chosen, greatest = NONE, -math.inf
    while child != NONE:
        bonus = search.c * math.sqrt(logarithm / tree.visits[child])
        confidence = scale * value_of(search, tree, child) + bonus
        if confidence > greatest:
            chosen, greatest = child, confidence
        child = tree.sibling[child]
    return chosen


@kernel
def move_to_play(search, tree, root):
    """Child to play: the most visited, or that of highest value.

    Ties go to the higher mean, then to the child made first.
    """
    chosen, most, highest = NONE, -math.inf, -math.inf
    child = tree.child[root]
    while child != NONE:
        mean = tree.total[child] / tree.visits[child]
        rank = value_of(search, tree, child) if search.by_value else tree.visits[child]
        if rank > most or (rank == most and mean >= highest):
            chosen, most, highest = child, rank, mean
        child = tree.sibling[child]
    return chosen


@kernel
def step(rules, policy, search, rng, tree, game, scratch, record):
    """Run the simulations of one step; returns the resulting move.

    Selection by UCT, one new node, a rollout, and the return in every node of the path. The
    return counts the prizes of the whole mission: of what was played, of the path and of the
    rollout. Within a step they differ from the prizes to come by a constant.

    Parameters
    ----------
    tree : Tree
        With room for the simulations and one more; begun anew at the root when room runs out.
    game : Game
    record : SearchRecord
        Updated.

    Returns
    -------
    body : int
        To be played; ``NONE`` if no move is left.
    root, used : int
        The node of that move, and the nodes in use.
    """
    rules, tree, scratch = borrowed(rules), borrowed(tree), borrowed(scratch)
    root, used, played, collected, visited = game
    if used + search.simulations > tree.body.size:
        used, root = copy_root(tree, root), 0
    path = scratch.path
    for _ in range(search.simulations):
        write(scratch.visited, visited)
        node, depth, moves, prizes = root, 0, played, collected
        path[0] = root
        while True:
            if tree.untried[node] == NOT_LISTED:
                list_moves(rules, policy, search, tree, node, scratch)
            child = expand(rules, search, rng, tree, node, used)
            is_new = child != NONE
            if is_new:
                used += 1
            else:
                child = select(search, tree, node, record)
                if child == NONE:
                    break
            node = child
            j = tree.body[node]
            scratch.visited[j] = not rules.is_station[j]
            prizes += rule_kernels.worth_at(rules, j, tree.resources.time[node])
            scratch.sequence[moves] = j
            depth, moves = depth + 1, moves + 1
            path[depth] = node
            if is_new:
                break
        moves, gain, spent = policies.rollout(
            rules, policy, rng, scratch, moves, _state_at(tree, node)
        )
        prizes += gain
        spent += tree.spent[node]
        for k in range(depth + 1):
            tree.visits[path[k]] += 1.0
            tree.total[path[k]] += prizes
            tree.best[path[k]] = max(tree.best[path[k]], prizes)
        record.returns[0] = min(record.returns[0], prizes)
        record.returns[1] = max(record.returns[1], prizes)
        if prizes > record.best[1] or (prizes == record.best[1] and spent < record.best[2]):
            record.best[0], record.best[1], record.best[2] = moves, prizes, spent
            write(record.sequence, scratch.sequence[:moves])
    chosen = move_to_play(search, tree, root)
    if chosen == NONE:
        return NONE, root, used
    body = tree.body[chosen]
    if search.keep:
        return body, chosen, used
    return body, 0, copy_root(tree, chosen)
