#!/bin/sh
#$ -N damperlab
#$ -l mem_free=2048M
#$ -l h_rt=01:30:30
#$ -j y -o /shared/jobs/one
#$ -S /bin/sh -V
#$ -t 1-8
#$ -q all.q
exec PYTHON -m damperlab admin worker tls://10.0.0.1:40123 --tls /shared/jobs/one/tls --lifetime 5370 --leave-within 25 --leave-idle 300 --memory-limit 2147483648B --name job-2-"${SGE_TASK_ID:-1}"
