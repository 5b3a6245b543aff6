#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The realised sea and its exact sum are the same bits whatever the compiler and its level: compiles what makes it with
# each compiler, contraction off, and compares the printed hashes with that of the build's own library.
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
for source in $sources; do printf '#include "%s"\n' "$source"; done >"$work_dir/all.cpp"
printf 'as built %s' "$hashes"
for how in "$@"; do
    compiler=${how%:*} level=${how##*:}
    program=$work_dir/hash$level-$(basename "$compiler")
    $compiler -std=c++20 $level -ffp-contract=off -Wno-psabi -I. "$work_dir/all.cpp" -o "$program" -lfmt
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
