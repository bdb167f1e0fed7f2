#!/bin/sh
#BSUB -n 1 -M 2048MB
#BSUB -R "rusage[mem=2048MB]"
#BSUB -W 01:31
#BSUB -o /shared/jobs/one/%J-%I.log
#BSUB -J "damperlab[1-8]"
#BSUB -q normal -P "my lab"
exec PYTHON -m damperlab admin worker tls://10.0.0.1:40123 --tls /shared/jobs/one/tls --lifetime 5370 --leave-within 25 --leave-idle 300 --memory-limit 2147483648B --name job-2-"${LSB_JOBINDEX:-1}"
