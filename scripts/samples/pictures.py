"""Procedural textures: colours, noise, PNG bytes."""
import io

import numpy as np
from PIL import Image


def srgb(code):
    """Linear RGB of a colour such as "#c04030"."""
    v = np.array([int(code.lstrip("#")[i:i + 2], 16) for i in (0, 2, 4)]) / 255
    return tuple(np.where(v <= 0.04045, v / 12.92, ((v + 0.055) / 1.055) ** 2.4))


def bytes_of(code):
    """The 8-bit sRGB values of a colour such as "#c04030"."""
    return np.array([int(code.lstrip("#")[i:i + 2], 16) for i in (0, 2, 4)], float)


def png(array, colours=None):
    """PNG of values 0–255; `colours` reduces it to a palette."""
    picture = Image.fromarray(np.clip(np.round(array), 0, 255).astype(np.uint8))
    if colours:
        picture = picture.quantize(colours, dither=Image.Dither.NONE)
    out = io.BytesIO()
    picture.save(out, "PNG", optimize=True)
    return out.getvalue()


def hashed(ix, iy, iz, seed):
    """A number in [0, 1) for each lattice point."""
    h = (ix.astype(np.uint32) * np.uint32(0x9E3779B1)) ^ (iy.astype(np.uint32) * np.uint32(0x85EBCA77))
    h ^= (iz.astype(np.uint32) * np.uint32(0xC2B2AE3D)) ^ np.uint32(seed * 0x27D4EB2F & 0xFFFFFFFF)
    for shift, factor in ((15, 0x2C1B3C6D), (12, 0x297A2D39)):
        h = (h ^ (h >> np.uint32(shift))) * np.uint32(factor)
    return (h ^ (h >> np.uint32(15))).astype(float) / 2.0 ** 32


def noise(p, seed=0):
    """Value noise in [0, 1] at points (…, 3), period-free."""
    base = np.floor(p).astype(np.int64)
    f = p - base
    f = f * f * f * (f * (f * 6 - 15) + 10)
    total = 0.0
    for corner in range(8):
        bits = [(corner >> k) & 1 for k in range(3)]
        weight = 1.0
        for k in range(3):
            weight = weight * (f[..., k] if bits[k] else 1 - f[..., k])
        total = total + weight * hashed(*(base[..., k] + bits[k] for k in range(3)), seed)
    return total


def fractal(p, octaves=5, seed=0):
    """Fractional Brownian motion of value noise, about in [0, 1]."""
    p = np.asarray(p, float)
    total, weight = 0.0, 0.5
    for k in range(octaves):
        total = total + weight * noise(p * 2.0 ** k + 17.3 * k, seed + k)
        weight /= 2
    return total / (1 - 0.5 ** octaves)


def smoothstep(low, high, x):
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def mix(a, b, t):
    return a + (b - a) * t


def normal_map(height, du, dv):
    """Normals (PNG values) of a height field; du, dv: size of a texel in the height's unit, arrays welcome.
    The field repeats across u. Green is up, against v."""
    x = (np.roll(height, -1, 1) - np.roll(height, 1, 1)) / (2 * du)
    y = np.gradient(height, axis=0) / dv
    n = np.stack([-x, y, np.ones_like(x)], -1)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return n * 127.5 + 127.5
