#!/usr/bin/env python3
"""ambient.py FOLDER: makes balls.gltf, four balls in a row (matt, matt with bumps, plastic, metal), and sky.hdr, a
panorama of an evening sky with a low sun above dark ground, for ambient.sh."""
import base64
import json
import math
import struct
import sys
import zlib

SIDES, RINGS = 64, 32  # of a ball
MAP = 64  # texels of a side of the map of normals
WIDTH = 512  # of the panorama


def png(side, texel):
    rows = b"".join(b"\0" + bytes(n for x in range(side) for n in texel(x, y)) for y in range(side))

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    header = struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


def bump(x, y):
    """The normal of a round bump that fills the map."""
    u, v = (2 * (n + 0.5) / MAP - 1 for n in (x, y))
    square = u * u + v * v
    n = (0.8 * u, -0.8 * v, math.sqrt(1 - 0.64 * square)) if square < 1 else (0, 0, 1)
    return [round(127.5 + 127.5 * k) for k in n]


def uri(data, kind="application/octet-stream"):
    return "data:%s;base64,%s" % (kind, base64.b64encode(data).decode())


def balls():
    places, uvs, triangles = [], [], []
    for ring in range(RINGS + 1):
        for side in range(SIDES + 1):
            theta, phi = math.pi * ring / RINGS, 2 * math.pi * side / SIDES
            places += [math.sin(theta) * math.sin(phi), math.cos(theta), math.sin(theta) * math.cos(phi)]
            uvs += [16 * side / SIDES, 8 * ring / RINGS]
    for ring in range(RINGS):
        for side in range(SIDES):
            a = ring * (SIDES + 1) + side
            b = a + SIDES + 1
            triangles += [a, b, a + 1] * (ring > 0) + [a + 1, b, b + 1] * (ring < RINGS - 1)
    parts = [struct.pack("<%df" % len(places), *places), struct.pack("<%df" % len(uvs), *uvs),
             struct.pack("<%dH" % len(triangles), *triangles)]
    vertices = len(places) // 3

    def material(color, metal, roughness, **more):
        return {"pbrMetallicRoughness": {"baseColorFactor": color + [1], "metallicFactor": metal,
                                         "roughnessFactor": roughness}, **more}
    nothing = {"KHR_materials_specular": {"specularFactor": 0}}
    return {
        "asset": {"version": "2.0"}, "scene": 0, "extensionsUsed": ["KHR_materials_specular"],
        "scenes": [{"nodes": [0, 1, 2, 3, 4]}],
        "nodes": [{"mesh": k, "translation": [2.2 * k - 3.3, 0, 0]} for k in range(4)] +
                 [{"camera": 0, "translation": [0, 0, 12]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.215, "znear": 0.1, "aspectRatio": 4}}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0, "TEXCOORD_0": 1}, "indices": 2,
                                    "material": k}]} for k in range(4)],
        "materials": [material([0.8, 0.8, 0.8], 0, 1, extensions=nothing),
                      material([0.8, 0.8, 0.8], 0, 1, extensions=nothing, normalTexture={"index": 0}),
                      material([0.5, 0.1, 0.08], 0, 0.4), material([0.95, 0.75, 0.45], 1, 0.35)],
        "textures": [{"source": 0}], "images": [{"uri": uri(png(MAP, bump), "image/png")}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": vertices, "type": "VEC3", "min": [-1, -1, -1],
                       "max": [1, 1, 1]},
                      {"bufferView": 1, "componentType": 5126, "count": vertices, "type": "VEC2"},
                      {"bufferView": 2, "componentType": 5123, "count": len(triangles), "type": "SCALAR"}],
        "bufferViews": [{"buffer": k, "byteLength": len(part)} for k, part in enumerate(parts)],
        "buffers": [{"uri": uri(part), "byteLength": len(part)} for part in parts],
    }


def radiance(x, y):
    """Of the evening: red at the horizon below the sun, blue above, brown ground."""
    theta, phi = math.pi * (y + 0.5) * 2 / WIDTH, 2 * math.pi * (x + 0.5) / WIDTH
    up = math.cos(theta)
    if abs(phi - 3.9) < 0.012 and abs(theta - 1.2) < 0.012:
        return 4000, 2800, 1500
    if up < 0:
        return 0.1, 0.07, 0.04
    glow = math.exp(-6 * up) * (0.6 + 0.4 * math.cos(phi - 3.9))
    return 0.12 + 1.6 * glow, 0.2 + 0.7 * glow, 0.5 + 0.2 * glow


def rgbe(color):
    exponent = math.frexp(max(color))[1]
    return bytes([int(c * 256 / 2.0 ** exponent) for c in color] + [exponent + 128])


def main(folder):
    with open(folder + "/balls.gltf", "w", encoding="ascii") as file:
        json.dump(balls(), file)
    with open(folder + "/sky.hdr", "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (WIDTH // 2, WIDTH))
        file.write(b"".join(rgbe(radiance(x, y)) for y in range(WIDTH // 2) for x in range(WIDTH)))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
