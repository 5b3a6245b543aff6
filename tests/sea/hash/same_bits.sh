#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The realised sea and its exact sum are the same bits whatever the compiler and its level: compiles what makes it with
# each compiler, contraction off, and compares the printed hashes with that of the build's own library. What was compiled
# of the same sources by the same compiler before is run again, not compiled again: that takes most of a minute.
#   same_bits.sh SOURCE_DIR WORK_DIR PROGRAM COMPILER:LEVEL...
set -eu
source_dir=$1
work_dir=$2
hashes="$("$3")
"
shift 3
mkdir -p "$work_dir"
cd "$source_dir"
# Rooms as a whole: a file that realisation comes to need is in the list by itself. As one source, since most of the time
# goes to headers that all of them read.
sources="tests/sea/hash/print_hash.cpp base/check.cpp base/csv_table.cpp base/instructions.cpp base/messages.cpp base/standard_files.cpp base/text_file.cpp
  $(ls sea/basics/*.cpp sea/spectrum/*.cpp sea/waves/*.cpp)"
for source in $sources; do printf '#include "%s"\n' "$source"; done >"$work_dir/all.new"
cmp -s "$work_dir/all.new" "$work_dir/all.cpp" || mv "$work_dir/all.new" "$work_dir/all.cpp"

read_by() { sed -e 's/^[^:]*://' -e 's/\\$//' "$1.d"; }
# Of all that a program was made of; a package may bring headers that are older than the program.
# shellcheck disable=SC2046
contents_of() { cat $(read_by "$1") 2>&1 | cksum; }

# Whether a program was made this way, of what is there now, and nothing is newer, or gone.
is_current() { # PROGRAM HOW
    # shellcheck disable=SC2046
    [ -x "$1" ] && [ -s "$1.d" ] && [ "$(cat "$1.how" 2>&1)" = "$2
$(contents_of "$1")" ] &&
        [ -z "$(find -L $(read_by "$1") -newer "$1" 2>&1)" ]
}

printf 'as built %s' "$hashes"
for how in "$@"; do
    compiler=${how%:*} level=${how##*:}
    program=$work_dir/hash$level-$(basename "$compiler")
    set -- "$compiler" -std=c++20 "$level" -ffp-contract=off -Wno-psabi -I. "$work_dir/all.cpp" -lfmt
    made="$*
$("$compiler" --version)"
    if ! is_current "$program" "$made"; then
        rm -f "$program.how"
        touch "$program.begun"
        "$@" -MD -MF "$program.d" -o "$program"
        touch -r "$program.begun" "$program" # what changes meanwhile is newer
        printf '%s\n%s\n' "$made" "$(contents_of "$program")" >"$program.how"
    fi
    hash=$("$program")
    echo "$compiler $level $hash"
    hashes="$hashes$hash
"
done
different=$(printf '%s' "$hashes" | sort -u | wc -l)
if [ "$different" -ne 1 ]; then
    echo "the realised sea depends on the compiler: $different different hashes" >&2
    exit 1
fi
