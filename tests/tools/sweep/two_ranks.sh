#!/bin/sh
# Runs a test program over two ranks. Exit code 77, saying why, where mpirun is missing or cannot start anything.
program=$1
command -v mpirun >/dev/null || { echo "SKIPPED: no mpirun"; exit 77; }
# Two ranks on one machine, whoever runs this: as root, on one core, in a container, without network or remote shell.
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
export OMPI_MCA_btl=self,vader OMPI_MCA_btl_vader_single_copy_mechanism=none OMPI_MCA_plm_rsh_agent=sh
export OMPI_MCA_mpi_yield_when_idle=1 OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_hwloc_base_binding_policy=none
scratch=$(mktemp -d /tmp/sanso_mpi_XXXXXX) && trap 'rm -rf "$scratch"' EXIT
export OMPI_MCA_orte_tmpdir_base="$scratch"  # short: sockets are made there
if ! mpirun -n 2 "$program" --gtest_filter=TwoRanks.AreTwo >"$scratch/log" 2>&1; then
  echo "SKIPPED: mpirun does not start two ranks here:"
  cat "$scratch/log"
  exit 77
fi
mpirun -n 2 "$program"
