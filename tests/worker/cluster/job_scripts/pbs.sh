#!/bin/sh
#PBS -N damperlab
#PBS -l select=1:ncpus=1:mem=2048mb
#PBS -l walltime=01:30:30
#PBS -j oe -o /shared/jobs/one/
#PBS -V
#PBS -J 1-8
#PBS -q workq
exec PYTHON -m damperlab admin worker tls://10.0.0.1:40123 --tls /shared/jobs/one/tls --lifetime 5370 --leave-within 25 --leave-idle 300 --memory-limit 2147483648B --name job-2-"${PBS_ARRAY_INDEX:-1}"
