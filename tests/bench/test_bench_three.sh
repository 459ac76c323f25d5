#!/bin/sh
# bench/peers/three.js: test_bench_three.sh SOURCE_DIR STILB NODE MODULES CHROMIUM
#
# What it refuses, what it says where three.js is missing, and, where it is there, one short run: both draw the same
# picture. Only where both draw it is the ratio of their times worth something.
set -u
peer="$1/bench/peers/three.js"
stilb=$2
node=$3
if [ ! -x "$node" ]; then
	echo "skipped: node is not installed"
	exit 77
fi
failed=0

# expect STATUS WORDS ARGUMENTS...: the run ends with STATUS, and says WORDS.
expect() {
	status=$1 words=$2
	shift 2
	said=$("$node" "$peer" "$@" 2>&1)
	got=$?
	case "$got $said" in
	"$status "*"$words"*) ;;
	*)
		echo "FAILED: three.js $*: status $got, not $status, or without '$words': $said"
		failed=1
		;;
	esac
}

unset STILB_NODE_MODULES
expect 77 "npm install three puppeteer-core" lights
expect 2 "the mode is lights, cascades or post" frames
expect 2 "--speed" lights --speed 3
expect 2 "--frames 0" lights --frames 0
expect 2 "WIDTHxHEIGHT" lights --size 640

STILB_NODE_MODULES=$4 STILB_CHROMIUM=$5
export STILB_NODE_MODULES STILB_CHROMIUM
if [ ! -d "$STILB_NODE_MODULES/three" ] || [ ! -d "$STILB_NODE_MODULES/puppeteer-core" ] || [ ! -x "$STILB_CHROMIUM" ]; then
	echo "no run: npm install three puppeteer-core, apt-get install chromium-headless-shell libegl1 libgl1-mesa-dri"
	exit $failed
fi
expect 2 "not there" lights --stilb ./no-stilb
short="--size 320x180 --frames 1 --rounds 1"
expect 0 "844 draws" cascades $short --stilb "$stilb"
expect 0 "469 draws" post $short
said=$("$node" "$peer" lights $short --stilb "$stilb") || failed=1
echo "$said"
# Silhouettes, where a pixel is of one triangle or another, and highlights differ.
rms=$(echo "$said" | sed -n 's/^pictures differ by \([0-9]*\)\..*/\1/p')
case "$rms" in
[0-3]) ;;
*)
	echo "FAILED: the pictures of three.js and Stilb differ by ${rms:-an unknown number of} steps"
	failed=1
	;;
esac
exit $failed
