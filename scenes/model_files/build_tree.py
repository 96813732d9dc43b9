"""From the nodes of a scene file to the parts of a model, checked by the names of nodes."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from lod.errors import InputError
from lod.shapes import Mesh, MeshTable
from scenes.model_files.part_tree import (
    MOST_NODES,
    MOST_TRIANGLES,
    Node,
    NodeSettings,
    PartTree,
    check_size,
)
from scenes.model_files.sidecar import Sidecar, settings_of


def build_tree(source: str, nodes: Sequence[Node], sidecar: Sidecar) -> PartTree:
    """Make the parts of a model from its nodes, those above before those below.

    A node with a mesh and nodes below it has its mesh as a part of its own. A node with nothing but
    one node below is one part with that. Several topmost nodes become parts of one whole.

    source: what errors call the file. Raises InputError that names the node and the rule.
    """
    check_node_count(source, len(nodes))
    if not any(node.mesh is not None for node in nodes):
        raise InputError(source, "no meshes", "the ends of a model are meshes", "add one")
    nodes = _one_whole(nodes)
    paths = node_paths(nodes)
    said = _settings(source, nodes, paths, sidecar)
    nodes, paths, said = _own_parts(nodes, paths, said)
    _refuse_empty(source, nodes, paths)
    rows = _kept(nodes, said)
    return _tree(source, nodes, paths, said, rows, sidecar.period)


def check_node_count(source: str, count: int) -> None:
    """Raise InputError for more nodes than a model may have."""
    if count > MOST_NODES:
        cure = "join meshes that are never seen apart"
        raise InputError(source, f"{count} nodes", f"a model has at most {MOST_NODES} nodes", cure)


def check_triangle_count(source: str, count: int) -> None:
    """Raise InputError for more triangles than a model may have, before any is read."""
    if count > MOST_TRIANGLES:
        rule = f"a model has at most {MOST_TRIANGLES} triangles"
        raise InputError(source, f"{count} triangles", rule, "decimate its meshes")


def node_paths(nodes: Sequence[Node]) -> list[str]:
    """Name every node by the names from the whole to it; namesakes are numbered from 2."""
    paths: list[str] = []
    seen: dict[str, int] = {}
    for node in nodes:
        lead = f"{paths[node.parent]}/" if node.parent >= 0 else ""
        path = f"{lead}{node.name.replace('/', '|')}"
        seen[path] = seen.get(path, 0) + 1
        paths.append(path if seen[path] == 1 else f"{path} ({seen[path]})")
    return paths


def _one_whole(nodes: Sequence[Node]) -> list[Node]:
    """The nodes below one topmost node, which is made where there are several."""
    if sum(node.parent < 0 for node in nodes) == 1:
        return list(nodes)
    whole = Node("whole", -1, np.eye(4), None, NodeSettings())
    return [whole, *(replace(node, parent=node.parent + 1) for node in nodes)]


def _settings(
    source: str, nodes: Sequence[Node], paths: Sequence[str], sidecar: Sidecar
) -> list[NodeSettings]:
    """What is said of every node; the albedo of a node holds below it, too."""
    unknown = sidecar.parts.keys() - set(paths)
    if unknown:
        where = f"{source}.toml: parts.{min(unknown)}"
        some = ", ".join(list(paths)[:4])
        raise InputError(where, "no such node", "the path of a node", f"as {some} …")
    said: list[NodeSettings] = []
    for node, path in zip(nodes, paths, strict=True):
        own = settings_of(sidecar.parts[path]) if path in sidecar.parts else node.settings
        if own.axis is not None and not np.any(own.axis):
            raise InputError(f"{source}: {path} axis", own.axis, "not zero", "try [0, 0, 1]")
        if own.albedo is None and node.parent >= 0:
            own = replace(own, albedo=said[node.parent].albedo)
        said.append(own)
    return said


def _own_parts(
    nodes: Sequence[Node], paths: Sequence[str], said: Sequence[NodeSettings]
) -> tuple[list[Node], list[str], list[NodeSettings]]:
    """Nodes that have a mesh or nodes below, and not both: such a mesh is a node of its own."""
    inner = {node.parent for node in nodes}
    more = [
        (replace(node, name="mesh", parent=row), f"{paths[row]} mesh")
        for row, node in enumerate(nodes)
        if row in inner and node.mesh is not None
    ]
    own = [replace(node, mesh=None) if row in inner else node for row, node in enumerate(nodes)] + [
        node for node, _ in more
    ]
    settings = [*said, *(NodeSettings(albedo=said[node.parent].albedo) for node, _ in more)]
    return own, [*paths, *(path for _, path in more)], settings


def _refuse_empty(source: str, nodes: Sequence[Node], paths: Sequence[str]) -> None:
    inner = {node.parent for node in nodes}
    for row, node in enumerate(nodes):
        if node.mesh is None and row not in inner:
            rule = "every node has a mesh or nodes below it"
            raise InputError(f"{source}: node {paths[row]}", "empty", rule, "take it out")


def _kept(nodes: Sequence[Node], said: Sequence[NodeSettings]) -> list[int]:
    """Rows of the nodes that become parts, wholes before parts: all but those that have one node
    below and nothing else, of which that takes the place."""
    below = np.bincount([node.parent for node in nodes if node.parent >= 0], minlength=len(nodes))
    depth: dict[int, int] = {}

    def depth_of(row: int) -> int:
        chain = []
        while row >= 0 and row not in depth:
            chain.append(row)
            row = nodes[row].parent
        for each in reversed(chain):
            depth[each] = depth.get(nodes[each].parent, -1) + 1
        return depth[chain[0]] if chain else depth[row]

    order = sorted(range(len(nodes)), key=depth_of)
    return [row for row in order if below[row] != 1 or said[row].axis is not None]


def _tree(
    source: str,
    nodes: Sequence[Node],
    paths: Sequence[str],
    said: Sequence[NodeSettings],
    rows: Sequence[int],
    period: float,
) -> PartTree:
    """The parts that stand in ``rows`` of the nodes."""
    number = {row: part for part, row in enumerate(rows)}
    parent: list[int] = []
    level: list[int] = []
    for row in rows:
        above = nodes[row].parent
        while above >= 0 and above not in number:
            above = nodes[above].parent
        parent.append(number[above] if above >= 0 else -1)
        least = level[parent[-1]] if parent[-1] >= 0 else 0
        asked = said[row].level
        if asked is not None and (asked < least or (parent[-1] < 0 and asked > 0)):
            where, rule = f"{source}: node {paths[row]} level", f"at least {least}, its whole's"
            raise InputError(where, asked, rule if parent[-1] >= 0 else "0 for the whole")
        level.append(asked if asked is not None else (least + 1 if parent[-1] >= 0 else 0))
    meshes = MeshTable.of([_coloured(nodes[row].mesh, said[row]) for row in rows])
    check_triangle_count(source, len(meshes))
    check_size(source, meshes, "mend the file's unit, or say metres_per_unit in FILE.toml")
    own: Mapping[str, np.ndarray] = {
        "axis": np.array([said[row].axis or (0.0, 0.0, 0.0) for row in rows]),
        "turns": np.array([0 if said[row].swing else said[row].turns for row in rows]),
        "swing": np.array([said[row].swing for row in rows]),
    }
    return PartTree(
        tuple(paths[row] for row in rows),
        np.array(parent),
        np.array(level),
        np.array([nodes[row].frame for row in rows]),
        meshes,
        **own,
        period=period,
    )


def _coloured(mesh: Mesh | None, said: NodeSettings) -> Mesh | None:
    if mesh is None or said.albedo is None:
        return mesh
    return replace(mesh, colours=np.tile(said.albedo, (len(mesh.vertices), 1)))
