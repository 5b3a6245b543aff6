#!/usr/bin/env bash
# The README's two commands on a bare machine: makes the smallest root of a Debian suite in a new
# folder, clones this checkout's HEAD into it and runs `./dev demo` and `./dev test` there.
#   tests/newcomer.sh SUITE [FOLDER]     as root; SUITE: bookworm, trixie; FOLDER: where it may write
# (default: below /tmp). Takes a quarter of an hour of two cores and 4 GB. The folder is removed if both
# pass and kept, for a look, if not. Needs debootstrap; SEAWAY_MIRROR names another mirror.
# Processes and mounts live in namespaces of their own, so that whatever happens in the root, none
# of them outlives this script and nothing of this machine is mounted in it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() { printf 'newcomer: %s\n' "$*" >&2; exit 1; }
[ $# -ge 1 ] || die "usage: tests/newcomer.sh SUITE [FOLDER]"
suite=$1
[ "$(id -u)" = 0 ] || die "debootstrap and chroot need root"
command -v debootstrap >/dev/null || die "debootstrap is missing: apt-get install debootstrap"
commit=$(git rev-parse HEAD)

folder=$(mktemp -d "${2:-/tmp}/newcomer-$suite.XXXXXX")
root=$folder/root
log=$folder/log
mirror=${SEAWAY_MIRROR:-http://deb.debian.org/debian}

say() { printf '%s newcomer %s: %s\n' "$(date +%T)" "$suite" "$*"; }
failed() { tail -n 40 "$log" >&2; die "$* failed; everything it said: $log"; }

say "a bare root in $root"
debootstrap --variant=minbase "$suite" "$root" "$mirror" >"$log" 2>&1 || failed debootstrap
git clone --quiet --no-hardlinks . "$root/seaway"
git -C "$root/seaway" checkout --quiet --detach "$commit"

in_root() { # command..., with an empty environment
  unshare --mount --pid --fork --kill-child bash -c '
    set -e
    mount --make-rprivate /
    mount -t proc proc "$1/proc"
    mount -t tmpfs tmpfs "$1/dev/shm"
    exec chroot "$1" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root \
      sh -c "cd /seaway && exec \"\$@\"" sh "${@:2}"' bash "$root" "$@"
}

for command in demo test; do
  say "./dev $command"
  in_root ./dev "$command" >>"$log" 2>&1 || failed "./dev $command"
  say "./dev $command passed: $(tail -n 1 "$log")"
done
rm -rf --one-file-system "$folder"
say "both commands pass at $commit"
