#!/usr/bin/env bash
# kernel.sh FOLDER: puts Debian's kernel and the modules that the tests of the tier vm load into FOLDER, from the
# package that linux-image-amd64 names. Nothing is installed. A second call finds the files and needs no network. If the
# package cannot be had, FOLDER/why has the reason, and the exit status is 1.
set -euo pipefail
mkdir -p "$1"
folder=$(cd "$1" && pwd)
download=$folder/download

modules=(
	drivers/hid/hid drivers/hid/hid-generic drivers/hid/uhid drivers/input/evdev
	drivers/usb/common/usb-common drivers/usb/core/usbcore drivers/hid/usbhid/usbhid
	drivers/input/ff-memless drivers/leds/led-class-multicolor drivers/hid/hid-sony
	drivers/usb/gadget/udc/udc-core drivers/usb/gadget/udc/dummy_hcd
	fs/configfs/configfs drivers/usb/gadget/libcomposite drivers/usb/gadget/function/usb_f_hid
)

say() {
	printf 'kernel.sh: %s\n' "$*" >&2
}

cannot() { # WHY
	rm -rf "$download"
	printf '%s\n' "$1" >"$folder/why"
	say "no kernel for the tests in a virtual machine: $1"
	exit 1
}

complete() {
	local module
	[ -s "$folder/vmlinux" ] || return 1
	for module in "${modules[@]}"; do
		[ -s "$folder/${module##*/}.ko" ] || return 1
	done
}

# The newest kernel's package, or nothing when apt has no lists.
kernel_package() {
	apt-cache show --no-all-versions linux-image-amd64 2>/dev/null | sed -n 's/^Depends: \(linux-image-[^ ,]*\).*/\1/p'
}

fetch() {
	local package
	package=$(kernel_package)
	[ -n "$package" ] || return 1
	say "downloading $package (70 MB), which is unpacked into $folder and not installed"
	(cd "$download" && apt-get download "$package" >&2)
}

# apt's lists are missing, or older than the archive.
update_lists() {
	local sudo=()
	if [ "$(id -u)" -ne 0 ]; then
		command -v sudo >/dev/null || cannot "apt's lists are missing or old: let root run apt-get update"
		sudo=(sudo)
	fi
	say "updating apt's lists"
	"${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get update >&2
}

# vmlinuz contains the compressed kernel; its position is in the header (Documentation/x86/boot.rst: setup_sects at 0x1f1,
# payload_offset at 0x248, payload_length at 0x24c; the last four bytes of the payload are its unpacked size). A
# virtual machine starts the unpacked one 2.4 s sooner.
unpack_kernel() { # VMLINUZ VMLINUX
	local sectors offset length
	sectors=$(od -An -tu1 -j 497 -N 1 "$1")
	read -r offset length < <(od -An -tu4 -j 584 -N 8 "$1")
	length=$((length - 4))
	head -c $(((sectors + 1) * 512 + offset + length)) "$1" | tail -c $length | xz -dc >"$2"
}

unpack() {
	local module patterns=()
	for module in "${modules[@]}"; do
		patterns+=("./lib/modules/*/kernel/$module.ko")
	done
	dpkg-deb --fsys-tarfile "$download"/*.deb |
		tar -xC "$download" --wildcards './boot/vmlinuz-*' "${patterns[@]}" &&
		mv "$download"/lib/modules/*/kernel/{drivers,fs} "$download" &&
		(cd "$download" && mv "${modules[@]/%/.ko}" "$folder") &&
		unpack_kernel "$download"/boot/vmlinuz-* "$download/vmlinux" &&
		mv "$download/vmlinux" "$folder/vmlinux" # last: it says that all is there
}

if complete; then
	exit 0
fi
[ "$(uname -m)" = x86_64 ] || cannot "the tests boot an x86-64 kernel, and this machine is $(uname -m)"
for tool in apt-get apt-cache dpkg-deb xz; do
	command -v $tool >/dev/null || cannot "no $tool here"
done
rm -rf "$download"
mkdir -p "$download"
fetch || { update_lists && fetch; } || cannot "the kernel's package could not be downloaded"
unpack || cannot "the kernel's package is not as expected"
complete || cannot "the kernel's package lacks a module"
rm -rf "$download" "$folder/why"
say "unpacked into $folder"
