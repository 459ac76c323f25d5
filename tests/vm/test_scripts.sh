#!/usr/bin/env bash
# Runs kernel.sh and boot.sh with stand-ins for apt and a package without a real kernel, and checks the files they fetch
# and leave and their messages when something is missing. Nothing is downloaded or booted.
set -uo pipefail
source=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
folder=$scratch/kernel
calls=$scratch/calls
failures=0

fail() {
	printf '%s\n' "$test: $*" "--- said" "$(cat "$scratch/said")" "--- calls" "$(cat "$calls")"
	failures=$((failures + 1))
}

stand_in() { # NAME SCRIPT: a command that writes down its call and then runs SCRIPT
	printf '#!/bin/bash\necho "%s $*" >>"%s"\n%s\n' "$1" "$calls" "$2" >"$scratch/bin/$1"
	chmod +x "$scratch/bin/$1"
}

little_endian() { # FILE OFFSET NUMBER: four bytes
	local i bytes=
	for i in 0 8 16 24; do
		bytes+=$(printf '\\x%02x' $((($3 >> i) & 255)))
	done
	# shellcheck disable=SC2059
	printf "$bytes" | dd of="$1" bs=1 seek="$2" conv=notrunc status=none
}

# make_package MODULE...: a Debian package with these modules and a vmlinuz whose packed part holds some words.
make_package() {
	local root=$scratch/package image=$scratch/package/boot/vmlinuz-9 module
	rm -rf "$root"
	mkdir -p "$root"/{DEBIAN,boot}
	printf 'Package: linux-image-9\nVersion: 1\nArchitecture: all\nMaintainer: none\nDescription: none\n' >"$root/DEBIAN/control"
	echo 'the kernel, unpacked' | xz >"$scratch/payload"
	{ head -c 1024 /dev/zero; printf 'loader'; cat "$scratch/payload"; printf 'size and more'; } >"$image"
	printf '\x01' | dd of="$image" bs=1 seek=497 conv=notrunc status=none # one sector after the first
	little_endian "$image" 584 6                                         # length of "loader"
	little_endian "$image" 588 $(($(stat -c %s "$scratch/payload") + 4))
	for module in "$@"; do
		mkdir -p "$root/lib/modules/9/kernel/${module%/*}"
		echo module >"$root/lib/modules/9/kernel/$module.ko"
	done
	dpkg-deb --build --root-owner-group "$root" "$scratch/linux-image-9.deb" >/dev/null
}

all_modules() { # as kernel.sh lists them
	sed -n '/^modules=(/,/^)/p' "$source/kernel.sh" | grep -oE '[a-z]+/[a-z_/-]+'
}

# A machine where apt has the package.
fresh_machine() {
	test=$1
	rm -rf "$scratch/bin" "$folder"
	mkdir -p "$scratch/bin"
	local tool
	for tool in bash cat cpio dirname env grep head ldd mkdir mktemp mv od printf rm sed tail tar dpkg-deb xz; do
		ln -s "$(command -v $tool)" "$scratch/bin/$tool"
	done
	stand_in apt-cache 'printf "Package: linux-image-amd64\nDepends: linux-image-9 (= 1), other\n"'
	stand_in apt-get "[ \$1 != download ] || cp '$scratch/linux-image-9.deb' ."
	ln -s "$(command -v cp)" "$scratch/bin/cp"
	stand_in uname 'echo x86_64'
	stand_in id 'echo 0'
	: >"$calls"
}

run() { # EXPECTED-EXIT PROGRAM ARGS...
	local wanted=$1 status
	shift
	env -i PATH="$scratch/bin" "$@" >"$scratch/said" 2>&1 </dev/null
	status=$?
	[ $status -eq "$wanted" ] || fail "exit status $status, not $wanted"
}

says() { # WORDS: they are in the last line
	tail -n 1 "$scratch/said" | grep -qF -- "$1" || fail "the last line lacks: $1"
}

test_kernel() {
	fresh_machine "fetches and unpacks"
	run 0 "$source/kernel.sh" "$folder"
	[ "$(cat "$folder/vmlinux")" = 'the kernel, unpacked' ] || fail "another kernel"
	local module
	for module in $(all_modules); do
		[ -s "$folder/${module##*/}.ko" ] || fail "no $module"
	done
	[ ! -e "$folder/download" ] || fail "the package is still there"
	grep -qxF 'apt-get download linux-image-9' "$calls" || fail "another package"

	test="what is there is kept"
	: >"$calls"
	run 0 "$source/kernel.sh" "$folder"
	[ ! -s "$calls" ] || fail "something was called"

	fresh_machine "no network"
	stand_in apt-get 'exit 100'
	run 1 "$source/kernel.sh" "$folder"
	grep -q 'could not be downloaded' "$folder/why" || fail "it does not say why"
	run 77 "$source/boot.sh" "$folder" "$scratch/log" /bin/true
	says "skipped: "

	test="the network is back"
	stand_in apt-get "[ \$1 != download ] || cp '$scratch/linux-image-9.deb' ."
	run 0 "$source/kernel.sh" "$folder"
	[ ! -e "$folder/why" ] || fail "it still says why"

	fresh_machine "apt's lists are missing"
	stand_in apt-cache "[ -e '$scratch/bin/updated' ] && echo 'Depends: linux-image-9 (= 1)'"
	stand_in apt-get "case \$1 in update) : >'$scratch/bin/updated' ;; *) cp '$scratch/linux-image-9.deb' . ;; esac"
	run 0 "$source/kernel.sh" "$folder"
	grep -qxF 'apt-get update' "$calls" || fail "they were not updated"

	fresh_machine "neither lists nor root nor sudo"
	stand_in apt-cache 'exit 100'
	stand_in id 'echo 1000'
	run 1 "$source/kernel.sh" "$folder"
	grep -q 'apt-get update' "$folder/why" || fail "it does not say what helps"

	fresh_machine "another processor"
	stand_in uname 'echo aarch64'
	run 1 "$source/kernel.sh" "$folder"
	grep -q 'aarch64' "$folder/why" || fail "it does not say why"

	fresh_machine "not Debian"
	rm "$scratch/bin/apt-get"
	run 1 "$source/kernel.sh" "$folder"
	grep -q 'no apt-get' "$folder/why" || fail "it does not say why"

	fresh_machine "a package without a module"
	make_package drivers/hid/hid fs/configfs/configfs
	run 1 "$source/kernel.sh" "$folder"
	grep -q 'not as expected' "$folder/why" || fail "it does not say why"
	[ ! -e "$folder/vmlinux" ] || fail "half of it passes for all"
}

test_boot_without() {
	fresh_machine "no QEMU"
	run 77 "$source/boot.sh" "$folder" "$scratch/log" /bin/true
	says "qemu-system-x86"

	fresh_machine "no kernel"
	stand_in qemu-system-x86_64 'exit 1'
	run 77 "$source/boot.sh" "$folder" "$scratch/log" /bin/true
	says "skipped: no kernel in $folder"
}

for tool in dpkg-deb xz cpio; do
	command -v $tool >/dev/null || { echo "skipped: no $tool here"; exit 77; }
done
# shellcheck disable=SC2046
make_package $(all_modules)
test_kernel
test_boot_without
[ $failures -eq 0 ] || { echo "$failures failed"; exit 1; }
echo "kernel.sh and boot.sh do what they say"
