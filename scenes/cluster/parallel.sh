#!/usr/bin/env bash
# Renders one image in parts by GNU parallel, on this machine or, with --sshloginfile in $PARALLEL, on many, and merges them.
#
#     scenes/cluster/parallel.sh PARTS IMAGE SCENE [FLAGS OF octray render]
#     scenes/cluster/parallel.sh 8 glass.exr scenes/glass.toml --spp 1024
#
# Run it again after whatever went wrong: parts that are there stay, others go on where they were. $OCTRAY names the program,
# $JOBS how many parts run at once (one, with all its threads, unless told otherwise).
set -euo pipefail
if [ $# -lt 3 ]; then
    sed -n '2,8s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
count=$1 image=$2
shift 2
octray=${OCTRAY:-octray}
parts="$image.parts"
mkdir -p "$parts"
export octray parts count
# The words of the command line reach every worker as they are, blanks and all.
flags=$(printf '%q ' "$@")
export flags

part() {
    local file="$parts/$1.part"
    if [ -e "$file" ]; then return 0; fi
    eval "set -- \"$1\" $flags"
    local number=$1
    shift
    "$octray" render "$@" --shard "$number/$count" -o "$file" --quiet
}
export -f part

# A part that fails is tried again, twice: a worker may have been killed.
parallel --jobs "${JOBS:-1}" --retries 3 --env part,octray,parts,count,flags part ::: $(seq "$count")
"$octray" merge "$parts"/*.part -o "$image"
