#!/bin/sh
#SBATCH --job-name=damperlab
#SBATCH --ntasks=1 --cpus-per-task=1 --mem=2048M
#SBATCH --time=01:30:30
#SBATCH --output=/shared/jobs/one/%A-%a.log
#SBATCH --export=ALL
#SBATCH --array=1-8
#SBATCH --partition=short
exec PYTHON -m damperlab admin worker tls://10.0.0.1:40123 --tls /shared/jobs/one/tls --lifetime 5370 --leave-within 25 --leave-idle 300 --memory-limit 2147483648B --name "job-2-${SLURM_ARRAY_TASK_ID}"
