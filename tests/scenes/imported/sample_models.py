"""The two models of the tests, made by these functions: a mill in USD, a lamp-post tree in glTF.

They are frozen: fitted appearances are judged by them, and may not be made to suit them.
"""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np

Points = np.ndarray

WHITE, WOOD, CANVAS, LEAF = (
    (0.75, 0.72, 0.68),
    (0.2, 0.12, 0.06),
    (0.7, 0.65, 0.5),
    (0.1, 0.2, 0.05),
)


def box(size: tuple[float, float, float]) -> tuple[Points, list[list[int]]]:
    """A box about the origin: 8 corners, 6 quads."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return corners * size, quads


def tube(low: float, high: float, length: float, sides: int = 12) -> tuple[Points, list[list[int]]]:
    """A tapering tube along z from the origin, closed above: quads and one polygon."""
    turn = 2 * math.pi * np.arange(sides) / sides
    ring = np.stack((np.cos(turn), np.sin(turn), np.zeros(sides)), axis=1)
    points = np.concatenate((ring * [low, low, 1], ring * [high, high, 1] + [0, 0, length]))
    nexts = [(k + 1) % sides for k in range(sides)]
    quads = [[k, nexts[k], sides + nexts[k], sides + k] for k in range(sides)]
    return points, [*quads, [sides + k for k in range(sides)]]


def mill(path: Path, turning: bool = True, unit: float = 0.01) -> Path:
    """Write a post mill of 5 levels, y up and in centimetres: mill, rotor, sail, lattice, slats."""
    from pxr import Gf, Usd, UsdGeom

    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageMetersPerUnit(stage, unit)
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.y)
    scale = 1 / unit

    def node(name: str, at: tuple[float, float, float], roll: float = 0.0) -> Any:
        xform = UsdGeom.Xform.Define(stage, name)
        xform.AddTranslateOp().Set(Gf.Vec3d(*(scale * x for x in at)))
        xform.AddRotateZOp().Set(roll)
        return xform

    def mesh(
        name: str, shape: tuple[Points, list[list[int]]], colour: Any, turn: Any = None
    ) -> None:
        points, polygons = shape
        points = points if turn is None else points @ np.array(turn, float).T
        made = UsdGeom.Mesh.Define(stage, name)
        made.CreatePointsAttr([Gf.Vec3f(*p) for p in (scale * points).tolist()])
        made.CreateFaceVertexCountsAttr([len(each) for each in polygons])
        made.CreateFaceVertexIndicesAttr([row for each in polygons for row in each])
        made.CreateDisplayColorPrimvar("constant").Set([Gf.Vec3f(*colour)])

    y_from_z = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
    stage.SetDefaultPrim(node("/mill", (0, 0, 0)).GetPrim())
    node("/mill/tower", (0, 0, 0))
    mesh("/mill/tower/wall", tube(2.2, 1.6, 8.0), WHITE, y_from_z)
    mesh("/mill/tower/roof", tube(1.9, 0.1, 1.8), WOOD, [[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    roof = UsdGeom.Mesh(stage.GetPrimAtPath("/mill/tower/roof"))
    roof.AddTranslateOp().Set(Gf.Vec3d(0, 8 * scale, 0))
    rotor = node("/mill/rotor", (0, 8.4, 2.6))
    if turning:
        from pxr import Sdf

        axis = rotor.GetPrim().CreateAttribute("lod:axis", Sdf.ValueTypeNames.Float3)
        axis.Set(Gf.Vec3f(0, 0, 1))
    mesh("/mill/rotor/hub", box((0.5, 0.5, 0.9)), WOOD)
    for k in range(4):
        sail = f"/mill/rotor/sail{k}"
        node(sail, (0, 0, 0.2), 90.0 * k + 20)
        mesh(f"{sail}/whip", tube(0.12, 0.07, 6.4, 8), WOOD, y_from_z)
        node(f"{sail}/lattice", (0.55, 1.6, 0))
        for row in range(3):
            panel = f"{sail}/lattice/panel{row}"
            node(panel, (0, 1.6 * row, 0))
            for slat in range(6):
                mesh(f"{panel}/slat{slat}", box((1.0, 0.2, 0.03)), CANVAS)
                made = UsdGeom.Mesh(stage.GetPrimAtPath(f"{panel}/slat{slat}"))
                made.AddTranslateOp().Set(Gf.Vec3d(0, 0.25 * slat * scale, 0))
    stage.Save()
    return path


def lamp_tree(path: Path, **changes: Any) -> Path:
    """Write a tree of lamp posts of 5 levels: tree, branch, arm, lamp, and its pane and frame.

    changes: entries of the header that are put in place of its own
    """
    header, data = lamp_tree_parts()
    header |= changes
    if path.suffix == ".glb":
        path.write_bytes(glb(header, data))
        return path
    header["buffers"] = [{"byteLength": len(data), "uri": f"{path.stem}.bin"}]
    path.with_suffix(".bin").write_bytes(data)
    path.write_text(json.dumps(header))
    return path


def glb(header: dict[str, Any], data: bytes) -> bytes:
    """Put a header and its data into one GLB file."""
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 4)
    chunks = len(text).to_bytes(4, "little") + b"JSON" + text
    chunks += len(data).to_bytes(4, "little") + b"BIN\0" + data
    return b"glTF" + (2).to_bytes(4, "little") + (12 + len(chunks)).to_bytes(4, "little") + chunks


def lamp_tree_parts() -> tuple[dict[str, Any], bytes]:
    """The header and the data of the lamp-post tree; y is up."""
    data, views, accessors = b"", [], []

    def accessor(values: np.ndarray, kind: str) -> int:
        nonlocal data
        raw = values.tobytes()
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(raw)})
        data += raw + b"\0" * (-len(raw) % 4)
        code = 5126 if values.dtype == np.float32 else 5123
        entry = {"bufferView": len(views) - 1, "componentType": code, "count": len(values)}
        if kind == "VEC3":
            entry |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        accessors.append(entry | {"type": kind})
        return len(accessors) - 1

    def mesh(name: str, shape: tuple[Points, list[list[int]]], material: int) -> dict[str, Any]:
        points = shape[0] @ np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
        rows = [(p[0], p[k], p[k + 1]) for p in shape[1] for k in range(1, len(p) - 1)]
        own = {"POSITION": accessor(points.astype(np.float32), "VEC3")}
        faces = accessor(np.array(rows, np.uint16).reshape(-1), "SCALAR")
        primitive = {"attributes": own, "indices": faces, "material": material}
        return {"name": name, "primitives": [primitive]}

    meshes = [
        mesh("trunk", tube(0.5, 0.25, 6.0), 0),
        mesh("arm", tube(0.12, 0.06, 2.0, 8), 0),
        mesh("pane", box((0.22, 0.02, 0.4)), 1),
        mesh("bar", box((0.03, 0.03, 0.5)), 2),
        mesh(
            "leaf",
            (
                np.array([[0, 0, 0], [0.2, 0, 0.2], [0, 0.1, 0.5], [-0.2, 0, 0.2]]),
                [[0, 1, 2], [0, 2, 3]],
            ),
            3,
        ),
    ]
    nodes = lamp_tree_nodes()
    materials = [
        {"name": name, "pbrMetallicRoughness": {"baseColorFactor": [*colour, 1.0]}}
        for name, colour in (("bark", WOOD), ("glass", WHITE), ("iron", (0.1,) * 3), ("leaf", LEAF))
    ]
    header = {
        "asset": {"version": "2.0", "generator": "the tests of lodbench"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    return header, data


def lamp_tree_nodes() -> list[dict[str, Any]]:
    """Tree → trunk and 5 branches → arm, 4 lamps and 8 leaves → 4 panes and 4 bars."""
    nodes: list[dict[str, Any]] = [{"name": "lamp tree", "children": []}]

    def add(parent: int, name: str, **rest: Any) -> int:
        nodes.append({"name": name, **rest})
        nodes[parent].setdefault("children", []).append(len(nodes) - 1)
        return len(nodes) - 1

    add(0, "trunk", mesh=0)
    for b in range(5):
        angle = 2 * math.pi * b / 5
        place = {"translation": [0, 3.0 + 0.6 * b, 0]}
        half = angle / 2
        branch = add(0, f"branch {b}", rotation=[0, math.sin(half), 0, math.cos(half)], **place)
        lean = [math.sin(0.55), 0, 0, math.cos(0.55)]
        add(branch, "arm", mesh=1, rotation=lean)
        for k in range(4):
            lamp = add(branch, f"lamp {k}", translation=[0.0, 0.1 + 0.22 * k, 0.4 + 0.45 * k])
            for side in range(4):
                quarter = side * math.pi / 4
                turn = {"rotation": [0, math.sin(quarter), 0, math.cos(quarter)]}
                frame = add(lamp, f"side {side}", **turn)
                add(frame, "pane", mesh=2, translation=[0, 0, 0.11])
                add(frame, "bar", mesh=3, translation=[0.11, 0, 0.11])
        for k in range(8):
            half = 0.4 * k
            turn = [0, math.sin(half), 0, math.cos(half)]
            add(branch, "leaf", mesh=4, translation=[0, 0.2 + 0.1 * k, 0.2 * k], rotation=turn)
    return nodes
