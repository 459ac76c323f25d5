#!/usr/bin/env bash
# boot.sh KERNEL LOG WORD...: boots the kernel of kernel.sh in a virtual machine, runs the words there as a shell command
# as root, and returns its exit status. Words that are programs here are copied into the machine with the libraries that
# they load. The machine's output goes to LOG. Needs no hardware, no KVM, no network and no root.
#
#   tests/vm/boot.sh build/vm-kernel build/vm.log build/release/tests/test_vm_pads
#
# Exit status 77: skipped, for the reason printed.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
kernel=$1 log=$2
shift 2

skip() {
	echo "skipped: $*"
	exit 77
}

# ---- what is needed --------------------------------------------------------------------------------------------------

for tool in qemu-system-x86_64:qemu-system-x86 cpio:cpio; do
	command -v "${tool%:*}" >/dev/null || skip "no ${tool%:*} here (package ${tool#*:})"
done
if [ ! -s "$kernel/vmlinux" ]; then
	why="it was not fetched; ./dev test does, or tests/vm/kernel.sh $kernel"
	[ ! -s "$kernel/why" ] || why=$(cat "$kernel/why")
	skip "no kernel in $kernel: $why"
fi
busybox=/bin/busybox
[ -x $busybox ] && ! ldd $busybox >/dev/null 2>&1 || skip "no static $busybox here (package busybox-static)"

# ---- the machine's files ---------------------------------------------------------------------------------------------

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
root=$scratch/root
mkdir -p "$root"/{bin,modules,proc,sys,dev,tmp}
cp $busybox "$root/bin"
cp "$here/init.sh" "$root/init"
cp "$kernel"/*.ko "$root/modules"
line=()
for word in "$@"; do
	if [ -f "$word" ] && [ -x "$word" ]; then
		cp "$word" "$root/bin"
		ldd "$word" | grep -o '/[^ ]*' | xargs -r cp -nL --parents -t "$root"
		word=/bin/${word##*/}
	fi
	line+=("$word")
done
echo "${line[*]}" >"$root/command"
(cd "$root" && find . | cpio -o -H newc --quiet) >"$scratch/initramfs"

# ---- run -------------------------------------------------------------------------------------------------------------

# -M pc has a timer with microseconds, which microvm lacks. A kernel that oopses ends the machine, and so the test.
timeout -k 5 "${STILB_VM_SECONDS:-240}" qemu-system-x86_64 -M pc -accel tcg,thread=multi -cpu max -smp 2 -m 512 \
	-nodefaults -no-user-config -display none -serial stdio -no-reboot \
	-kernel "$kernel/vmlinux" -initrd "$scratch/initramfs" \
	-append "console=ttyS0 quiet oops=panic panic=-1 reboot=t mitigations=off cryptomgr.notests" </dev/null 2>&1 |
	sed -u 's/\r$//' | tee "$log" || echo "vm: the machine did not end by itself"
status=$(sed -n 's/^vm: exit status \([0-9]*\)$/\1/p' "$log" | tail -n 1)
[ -n "$status" ] || echo "vm: the program did not end; see $log"
exit "${status:-1}"
