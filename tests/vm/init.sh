#!/bin/busybox sh
# The first and only process of the virtual machine's system: mounts, loads the modules, runs the command that boot.sh
# left, and turns the machine off. There is no udevd: devtmpfs makes the nodes.
bb=/bin/busybox
$bb mount -t proc none /proc
$bb mount -t sysfs none /sys
$bb mount -t devtmpfs none /dev
$bb mount -t tmpfs none /tmp
exec >/dev/ttyS0 2>&1

# Each after what it needs ("depends" in its .modinfo).
while read -r module parameters; do
	$bb insmod /modules/$module.ko $parameters || echo "vm: $module was not loaded"
done <<END
hid
hid-generic
uhid
evdev
usb-common
usbcore
usbhid
ff-memless
led-class-multicolor
hid-sony
udc-core
dummy_hcd num=2
configfs
libcomposite
usb_f_hid
END
$bb mount -t configfs none /sys/kernel/config
$bb mount -t debugfs none /sys/kernel/debug

export PATH=/bin HOME=/tmp
cd /tmp || exit
echo "vm: Linux $($bb uname -r), up after $($bb cut -d ' ' -f 1 /proc/uptime) s"
$bb sh /command
echo "vm: exit status $?"
$bb dmesg | $bb grep segfault | $bb tail -n 3 | $bb sed 's/^/vm: /'
$bb cut -d ' ' -f 1 /proc/uptime | $bb sed 's/^/vm: off after /;s/$/ s/'
$bb reboot -f
