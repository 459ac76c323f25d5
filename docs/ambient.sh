#!/bin/bash
# ambient.sh STILB OUT.png: makes docs/ambient.png: four balls under an evening sky as rays trace them, without light that
# one hands on to another, and by each kind of --ambient, below it four times what it differs. STILB is a build with a
# Vulkan driver. Needs python3 and ImageMagick's convert and montage (apt install imagemagick).
set -eu
[ $# = 2 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0"; exit 2; }
stilb=$(realpath "$1") out=$2
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
python3 "$(dirname "$0")/ambient.py" "$folder"
scene=("$folder/balls.gltf" --environment "$folder/sky.hdr" --camera 1 --exposure 0 --quiet --size 480x120)
name() { # FILE TEXT
	convert "$1" -background white -fill black \( -size 480x22 -pointsize 13 -gravity center caption:"$2" \) -append "$1"
}
"$stilb" render "${scene[@]}" --integrator direct --shadows off --spp 1024 -o "$folder/traced.png" >"$folder/said"
number=0
for kind in environment sh-pixel sh-vertex hemisphere constant none; do
	number=$((number + 1))
	"$stilb" view "${scene[@]}" --headless --msaa 4 --shadows off --ambient $kind --screenshot "$folder/frame.png" >"$folder/said"
	convert "$folder/frame.png" "$folder/traced.png" -compose difference -composite -evaluate multiply 4 "$folder/off.png"
	convert "$folder/frame.png" "$folder/off.png" -append +repage "$folder/cell-$number.png"
	name "$folder/cell-$number.png" $kind
done
convert "$folder/traced.png" -background white -gravity north -extent 480x240 "$folder/cell-0.png"
name "$folder/cell-0.png" "stilb render"
montage "$folder"/cell-?.png -tile 2x -geometry +3+3 -background white -depth 8 -strip -define png:color-type=2 "$out"
