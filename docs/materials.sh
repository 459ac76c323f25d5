#!/bin/bash
# materials.sh TEST OUT.png: makes docs/materials.png, the frames of the small files of tests/engine/answers, each with
# its name. TEST is test_engine_answers of a build with a Vulkan driver; it also holds the frames against rays. Needs
# ImageMagick's convert and montage (apt install imagemagick).
set -eu
[ $# = 2 ] || { sed -n '2,4s/^# \{0,1\}//p' "$0"; exit 2; }
test=$(realpath "$1") out=$2
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
mkdir "$folder/named"
(cd "$folder" && STILB_TRUTH_PICTURES=$folder "$test" >said) # what it writes beside, and leaves if it is stopped, is there
rm -f "$folder"/channel:*.png
for picture in "$folder"/*.png; do # the frame is the left third
	name=$(basename "$picture" .png)
	convert "$picture[64x64+0+0]" -resize 96x96 -gravity center -size 100x22 -pointsize 9 caption:"$name" -append \
		"$folder/named/$name.png"
done
montage "$folder"/named/*.png -tile 10x -geometry +2+2 -background white -depth 8 -strip -define png:color-type=2 "$out"
