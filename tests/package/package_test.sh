#!/usr/bin/env bash
# The Debian packages: made, read by lintian, installed into an empty root, used there, and removed without a trace.
#   package_test.sh BUILD SOURCE
set -euo pipefail
build=$1 source=$2
for tool in lintian desktop-file-validate dpkg-shlibdeps fakeroot man; do
    command -v "$tool" >/dev/null || { echo "$tool is not installed: scripts/install --development brings it"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
fail() { echo "$*" >&2; exit 1; }

cmake --build "$build" --target cmpg-vk cmpg_shared manual >"$work/build.log" || { cat "$work/build.log"; exit 1; }
(cd "$build" && cpack -G DEB -B "$work/packages") >"$work/cpack.log" 2>&1 || { cat "$work/cpack.log"; exit 1; }
packages=("$work"/packages/*.deb)
# Without the tool that finds dependencies there are no packages rather than some without dependencies.
message=$(cd "$build" && cpack -G DEB -B "$work/lacking" -D "CMAKE_IGNORE_PATH=$(type -ap dpkg-shlibdeps | xargs -n 1 dirname | paste -sd ';')" 2>&1) &&
    fail "packages were made without dpkg-shlibdeps"
[[ $message == *"dpkg-shlibdeps is not installed"* ]] || fail "cpack does not say what is missing: $message"
for package in "${packages[@]}"; do
    [[ $(dpkg-deb -f "$package" Depends) == *libstdc++6* ]] || fail "$package does not depend on what it needs"
    [[ $package == */cmpg-vk-mpi_* ]] || # depends on cmpg-vk
        [[ $(dpkg-deb -f "$package" Depends) == *libvulkan1* && $(dpkg-deb -f "$package" Recommends) == *mesa-vulkan-drivers* ]] || fail "$package brings no Vulkan"
done
# The project has no address, and its packages close no bug of Debian's.
lintian --fail-on error --suppress-tags bogus-mail-host,bogus-mail-host-in-debian-changelog,initial-upload-closes-no-bugs "${packages[@]}"

root=$work/root
mkdir -p "$root/var/lib/dpkg/info" "$root/var/lib/dpkg/updates" "$root/var/lib/dpkg/triggers"
touch "$root/var/lib/dpkg/status"
# Nothing but these packages: the libraries that they need are this machine's.
dpkg_root() { fakeroot dpkg --root="$root" --force-depends --force-not-root --force-script-chrootless --log=/dev/null "$@" >"$work/dpkg.log" 2>&1 || { cat "$work/dpkg.log"; exit 1; }; }
dpkg_root --install "${packages[@]}"
program=$root/usr/bin/cmpg-vk
# Texts whole: a program whose reader leaves at the first match ends by a signal.
[[ $("$program" --headless --help) == *optimize* ]] || fail "the installed program does not answer"
[[ $("$program" --version) == *cmpg-vk* ]] || fail "the installed program finds no device"
message=$(env -u DISPLAY -u WAYLAND_DISPLAY "$program" "$source/scenes/box/scene.gltf" 2>&1 || true)
[[ $message != *"libcmpg-viewer.so is missing"* ]] || fail "the installed program does not find its window: $message"
MANROFFSEQ='' MANWIDTH=80 man --warnings -E UTF-8 -l -Tutf8 -Z "$root/usr/share/man/man1/cmpg-vk.1.gz" >/dev/null 2>"$work/man.log"
[ ! -s "$work/man.log" ] || fail "the manual page: $(cat "$work/man.log")"
for option in spp list-devices version spp-gradient; do
    [[ $(zcat "$root/usr/share/man/man1/cmpg-vk.1.gz") == *".B \\-\\-${option//-/\\-}"$'\n'* ]] || fail "the manual page lacks --$option"
done
desktop-file-validate "$root/usr/share/applications/cmpg-vk.desktop"
# offers EXPECTED WORD...: what completion makes of the last word, in a folder of one file.
mkdir "$work/files" && touch "$work/files/a picture.exr"
offers() {
    local expected=$1 found
    shift
    found=$(cd "$work/files" && bash -c "source '$root/usr/share/bash-completion/completions/cmpg-vk'"'; COMP_WORDS=(cmpg-vk "$@"); COMP_CWORD=$#; _cmpg_vk; printf "<%s>" "${COMPREPLY[@]}"' _ "$@")
    [[ $found == "$expected" ]] || fail "completion offers '$found' for $*"
}
offers "<--optimizer>" optimize --opt
offers "<independent>" render --sampler in
offers "<a picture.exr>" compare --reference a
offers "<a picture.exr>" compare --set a
offers "<--list-devices>" --li
offers "<--version>" --vers
offers "<--param>" scene.gltf --par # without a command a window opens
offers "<open><optimize>" o
offers "<optimize>" --headless o
offers "<>" --headless scene.gltf --par
for header in cmpg/cmpg.h cmpg/error.h; do [ -f "$root/usr/include/$header" ] || fail "no header $header"; done

names=$(for p in "${packages[@]}"; do dpkg-deb -f "$p" Package; done)
dpkg_root --remove $names
left=$(dpkg-query --admindir="$root/var/lib/dpkg" -W | grep -v '^libcmpg-dev' || true) # whose library has scripts for ldconfig, which stay until it is purged
[ -z "$left" ] || fail "still known when they are removed: $left"
dpkg_root --purge libcmpg-dev
left=$(find "$root" -path "$root/var/lib/dpkg" -prune -o -type f -print)
[ -z "$left" ] || fail "left behind: $left"
