#!/usr/bin/env python3
"""lamp.py OUT.glb: makes docs/lamp.glb, a desk lamp that hops: its neck is a skin of eight joints, which bend it."""
import json
import math
import struct
import sys

JOINTS = 8  # of the neck, one above the other
NECK = 0.44  # metres from the base to the shade
SECONDS = 1.6  # of two hops
KEYS = 48


class Mesh:
    def __init__(self):
        self.vertices, self.triangles = [], []  # position, normal, joints, weights

    def turned(self, outline, sides, joint_of, smooth=True):
        """A surface of revolution about y. outline: (radius, height, radius and height of the normal)."""
        first = len(self.vertices)
        for radius, height, across, up in outline:
            for side in range(sides + 1):
                angle = 2 * math.pi * side / sides
                cosine, sine = math.cos(angle), math.sin(angle)
                joints, weights = joint_of(height)
                self.vertices.append(((radius * cosine, height, radius * sine), (across * cosine, up, across * sine),
                                      joints, weights))
        for ring in range(len(outline) - 1):
            for side in range(sides):
                a = first + ring * (sides + 1) + side
                b = a + sides + 1
                self.triangles += [(a, b, a + 1), (a + 1, b, b + 1)]


def profile(points):
    """Normals of an outline from below to above, one for each end of each piece, so that its corners are sharp."""
    out = []
    for (r0, h0), (r1, h1) in zip(points, points[1:]):
        length = math.hypot(r1 - r0, h1 - h0)
        across, up = (h1 - h0) / length, (r0 - r1) / length
        out += [(r0, h0, across, up), (r1, h1, across, up)]
    return out


def pieces(mesh, points, sides, joint):
    for k in range(0, 2 * len(points) - 2, 2):
        mesh.turned(profile(points)[k:k + 2], sides, lambda height: ((joint, 0), (255, 0)))


def neck_joints(height):
    """The two joints about a place of the neck, by how near they are; joint 0 is the base, JOINTS the shade."""
    along = min(max((height - 0.03) / NECK, 0.0), 1.0) * JOINTS
    low = min(int(along), JOINTS - 1)
    share = round(255 * (along - low))
    return (low, low + 1), (255 - share, share)


def make_meshes():
    metal, neck, glow = Mesh(), Mesh(), Mesh()
    pieces(metal, [(0, 0), (0.13, 0), (0.135, 0.012), (0.12, 0.028), (0.02, 0.034), (0.02, 0.05), (0, 0.05)], 40, 0)
    top = 0.03 + NECK
    shade = [(0.03, top + 0.02), (0.045, top + 0.03), (0.11, top + 0.15), (0.112, top + 0.153), (0.105, top + 0.15),
             (0.04, top + 0.035), (0, top + 0.03)]
    pieces(metal, [(0, top - 0.01), (0.03, top - 0.01), (0.03, top + 0.02)] + shade[1:], 40, JOINTS)
    rings = 6 * JOINTS
    neck.turned([(0.016 + 0.003 * (ring % 2), 0.03 + NECK * ring / rings, 1, 0) for ring in range(rings + 1)], 14,
                neck_joints)
    bulb = [(0.05 * math.cos(a), top + 0.085 + 0.05 * math.sin(a), math.cos(a), math.sin(a))
            for a in (math.pi * (k / 12 - 0.5) for k in range(13))]
    glow.turned(bulb, 24, lambda height: ((JOINTS, 0), (255, 0)))
    return metal, neck, glow


def pose(share):
    """Height of the base, how far it leans, and how far each joint of the neck bends, at a share of one hop."""
    phase = (2 * share) % 1.0
    left = int(2 * share) % 2 == 0
    if phase < 0.35:  # it crouches
        low = math.sin(math.pi * phase / 0.35)
        return 0.0, 0.0, 0.22 * low, left
    if phase < 0.8:  # it flies
        flight = (phase - 0.35) / 0.45
        return 0.2 * 4 * flight * (1 - flight), 0.25 * math.sin(2 * math.pi * flight), -0.07 * math.sin(
            math.pi * flight), left
    landing = (phase - 0.8) / 0.2
    return 0.0, 0.0, 0.1 * math.sin(math.pi * landing), left


def turn(angle, tilt):
    """A rotation about x by angle, then about z by tilt."""
    a, b = angle / 2, tilt / 2
    return (math.sin(a) * math.cos(b), math.sin(a) * math.sin(b), math.cos(a) * math.sin(b), math.cos(a) * math.cos(b))


class File:
    def __init__(self):
        self.data, self.views, self.accessors = b"", [], []

    def add(self, numbers, code, width, **more):
        packed = struct.pack("<%d%s" % (len(numbers), code), *numbers)
        self.views.append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(packed)})
        self.data += packed + b"\0" * (-len(packed) % 4)
        kinds = {"f": 5126, "H": 5123, "B": 5121}
        shapes = {1: "SCALAR", 3: "VEC3", 4: "VEC4", 16: "MAT4"}
        self.accessors.append({"bufferView": len(self.views) - 1, "componentType": kinds[code],
                               "count": len(numbers) // width, "type": shapes[width], **more})
        return len(self.accessors) - 1


def primitive(file, mesh, material):
    flat = lambda part: [n for vertex in mesh.vertices for n in vertex[part]]
    pad = lambda part: [n for vertex in mesh.vertices for n in (*vertex[part], 0, 0)]
    low = [min(v[0][k] for v in mesh.vertices) for k in range(3)]
    high = [max(v[0][k] for v in mesh.vertices) for k in range(3)]
    return {"material": material,
            "indices": file.add([i for t in mesh.triangles for i in t], "H", 1),
            "attributes": {"POSITION": file.add(flat(0), "f", 3, min=low, max=high), "NORMAL": file.add(flat(1), "f", 3),
                           "JOINTS_0": file.add(pad(2), "B", 4),
                           "WEIGHTS_0": file.add(pad(3), "B", 4, normalized=True)}}


def main(name):
    file = File()
    step = NECK / JOINTS
    heights = [0.0] + [0.03 + step * j for j in range(1, JOINTS + 1)]
    nodes = [{"name": "lamp", "mesh": 0, "skin": 0}]
    for j, height in enumerate(heights):
        node = {"name": "base" if j == 0 else "neck %d" % j,
                "translation": [0, height - (heights[j - 1] if j else 0), 0]}
        if j < JOINTS:
            node["children"] = [j + 2]
        nodes.append(node)
    binds = [n for height in heights for n in (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -height, 0, 1)]
    meshes = [primitive(file, mesh, m) for m, mesh in enumerate(make_meshes())]
    times = [SECONDS * k / KEYS for k in range(KEYS + 1)]
    poses = [pose(k / KEYS) for k in range(KEYS + 1)]
    samplers, channels = [], []

    def channel(node, path, values, width):
        samplers.append({"input": clock, "output": file.add([n for v in values for n in v], "f", width)})
        channels.append({"sampler": len(samplers) - 1, "target": {"node": node, "path": path}})

    clock = file.add(times, "f", 1, min=[0], max=[SECONDS])
    channel(1, "translation", [(0, up, 0) for up, lean, bend, left in poses], 3)
    channel(1, "rotation", [turn(lean, 0) for up, lean, bend, left in poses], 4)
    for j in range(1, JOINTS + 1):  # it crouches in an S: the lower half bends back, the upper one forward
        sign = -1.0 if j <= JOINTS // 2 else 1.55
        looks = 0.9 if j == JOINTS else 0.0
        channel(1 + j, "rotation", [turn(sign * bend * 1.6 + looks, (0.25 if left else -0.25) * bend)
                                    for up, lean, bend, left in poses], 4)
    document = {
        "asset": {"version": "2.0", "generator": "docs/lamp.py"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": nodes, "meshes": [{"primitives": meshes}],
        "skins": [{"joints": list(range(1, JOINTS + 2)), "inverseBindMatrices": file.add(binds, "f", 16)}],
        "animations": [{"name": "hop", "samplers": samplers, "channels": channels}],
        "materials": [
            {"name": "enamel", "doubleSided": True, "pbrMetallicRoughness": {
                "baseColorFactor": [0.62, 0.07, 0.03, 1], "metallicFactor": 0, "roughnessFactor": 0.3}},
            {"name": "steel", "pbrMetallicRoughness": {
                "baseColorFactor": [0.75, 0.74, 0.72, 1], "metallicFactor": 1, "roughnessFactor": 0.35}},
            {"name": "bulb", "pbrMetallicRoughness": {
                "baseColorFactor": [0.9, 0.72, 0.35, 1], "metallicFactor": 0, "roughnessFactor": 0.4}}],
        "accessors": file.accessors, "bufferViews": file.views, "buffers": [{"byteLength": len(file.data)}]}
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    with open(name, "wb") as out:
        out.write(struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(file.data), len(text), 0x4E4F534A) + text)
        out.write(struct.pack("<II", len(file.data), 0x004E4942) + file.data)


if len(sys.argv) != 2:
    sys.exit(__doc__)
main(sys.argv[1])
