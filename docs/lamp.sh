#!/bin/bash
# lamp.sh STILB OUT.png: makes docs/lamp.png, eight poses of docs/lamp.glb by `stilb render`, a hop from left to right.
# docs/lamp.py makes that file. Needs ImageMagick's convert (apt install imagemagick).
set -eu
[ $# = 2 ] || { sed -n '2,3s/^# \{0,1\}//p' "$0"; exit 2; }
stilb=$1 out=$2
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
"$stilb" render "$(dirname "$0")/lamp.glb" --quiet --size 130x265 --spp 256 --frames 0..7 --fps 10 \
	--camera 0.55,0.72,1.25,23.7,-11.6,39.3 -o "$folder/pose.png" >"$folder/said"
convert "$folder"/pose-*.png +append -strip -define png:color-type=2 "$out"
