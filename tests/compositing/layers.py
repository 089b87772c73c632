"""What oiiotool, OpenImageIO and a reader of Cryptomattes see in an EXR file of Kiln's. Arguments: the file, oiiotool's words."""

import json
import sys

import cryptomatte_api
import numpy as np
import OpenImageIO as oiio

path, told = sys.argv[1], open(sys.argv[2], encoding="utf-8").read()
for word in ["96 x   96", "albedo.R", "normal.X", "depth.Z", "variance.R", "CryptoObject00.R", "MurmurHash3_32", "uint32_to_float32"]:
    assert word in told, (word, told)

image = oiio.ImageInput.open(path)
names = image.spec().channelnames
pixels = dict(zip(names, np.moveaxis(image.read_image("float"), 2, 0)))
alpha = pixels["A"]
whole, nothing = alpha == 1, alpha == 0
assert whole.sum() > 1000 and nothing.sum() > 100
albedo = np.stack([pixels[f"albedo.{c}"] for c in "RGB"])
assert albedo.min() >= 0 and albedo.max() <= 1 and albedo[:, whole].mean() > 0.05 and (albedo[:, nothing] == 0).all()
lengths = np.sqrt(sum(pixels[f"normal.{c}"] ** 2 for c in "XYZ"))
assert lengths.max() < 1.0001 and np.median(lengths[whole]) > 0.99
assert np.isfinite(pixels["depth.Z"][alpha > 0]).all() and np.isinf(pixels["depth.Z"][nothing]).all()

mattes = cryptomatte_api.Cryptomatte.load(path)
assert len(mattes) == 2, mattes
spec = image.spec()
for matte in mattes:
    masks = matte.masks()
    named = [spec.get_string_attribute(a.name) for a in spec.extra_attribs if a.name.endswith("/manifest")]
    known = next(m for m in map(json.loads, named) if set(m) == set(masks))
    seen = {name: float(mask.mean()) for name, mask in masks.items()}
    assert len(known) == len(masks) >= 2 and sum(v > 0.001 for v in seen.values()) >= 2, seen
    covered = sum(np.asarray(mask).reshape(alpha.shape) for mask in masks.values())
    assert np.abs(covered - alpha).max() < 1e-3, np.abs(covered - alpha).max()
    print("Cryptomatte:", {name: round(share, 4) for name, share in seen.items()})
