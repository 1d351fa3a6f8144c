#!/usr/bin/env bash
# Renders one image in parts by a Slurm job array, and merges them.
#
#     sbatch --array=1-PARTS scenes/cluster/slurm.sh PARTS IMAGE SCENE [FLAGS OF octray render]
#     sbatch --array=1-8 scenes/cluster/slurm.sh 8 glass.exr scenes/glass.toml --spp 1024
#
# and, once all of it is done (JOB is the number that sbatch has printed):
#
#     sbatch --dependency=afterok:JOB scenes/cluster/slurm.sh 8 glass.exr
#
# A part whose worker was killed is sent again by its number (--array=3): it goes on where it was. $OCTRAY names the program.
# Which parts are missing is said by: octray merge --list IMAGE.parts/*.part
#SBATCH --job-name=octray
#SBATCH --requeue
#SBATCH --open-mode=append
set -euo pipefail
if [ $# -lt 2 ]; then
    sed -n '2,14s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
count=$1 image=$2
shift 2
octray=${OCTRAY:-octray}
parts="$image.parts"
mkdir -p "$parts"
number=${SLURM_ARRAY_TASK_ID:-}
if [ -z "$number" ]; then
    exec "$octray" merge "$parts"/*.part -o "$image"
fi
file="$parts/$number.part"
if [ -e "$file" ]; then exit 0; fi
exec "$octray" render "$@" --shard "$number/$count" -o "$file" --threads "${SLURM_CPUS_PER_TASK:-1}" --every 1m --quiet
