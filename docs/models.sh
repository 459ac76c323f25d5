#!/bin/bash
# models.sh STILB OUT.png: makes docs/models.png, ten models of Debian's package assimp-testmodels, each by `stilb view`
# (left) and by `stilb render` (right), with the flags of both at their defaults but for size, samples and shadows of
# frames, of which there are none. Needs ImageMagick's montage (apt install imagemagick).
set -eu
[ $# = 2 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0"; exit 2; }
stilb=$1 out=$2 models=/usr/share/assimp/models
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
number=0
for model in OBJ/spider.obj PLY/Wuson.ply Collada/teapots.DAE Q3D/earth.q3o X/fromtruespace_bin32.x \
	3DS/fels.3ds X3D/ComputerKeyboard.x3d Collada/Cinema4D.dae BLEND/Suzanne_248.blend \
	glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb; do
	number=$((number + 1))
	name=$folder/$(printf %02d $number)
	"$stilb" view "$models/$model" --quiet --headless --shadows off --size 180x135 --msaa 4 --screenshot "$name-a.png" >"$folder/said"
	"$stilb" render "$models/$model" --quiet --force --size 180x135 --spp 256 -o "$name-b.png" >"$folder/said"
done
montage "$folder"/*.png -tile 4x5 -geometry +1+1 -background white -strip "$out"
