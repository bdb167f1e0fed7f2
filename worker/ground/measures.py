"""The measures of a response to a record."""

from dataclasses import asdict, dataclass

from damperlab.studies.shapes import Count, Measured


@dataclass(frozen=True)
class GroundResponse:
    """Response of a design to a record; peaks are true extrema, rms values exact integrals over `duration_s`.

    Parameters
    ----------
    peak_relative_displacement_m, rms_relative_displacement_m : float
        Displacement of the primary mass against the base, x − z.
    peak_absolute_displacement_m, rms_absolute_displacement_m : float
        Displacement of the primary mass against its initial position, x; the displacement of the base is the record
        integrated twice.
    peak_absolute_acceleration_m_s2, rms_absolute_acceleration_m_s2 : float
        x'', including contact with a compliant wall; an instantaneous impact has no finite acceleration and is left
        out.
    impacts : int
        Number of impacts.
    impact_speed_max_m_s : float
        Largest approach speed of an impact.
    stick_fraction : float
        Share of the time that friction held the mass.
    work_in_j, loss_viscous_j, loss_friction_j, loss_impact_j : float
        Work of the base, and energy lost in the dashpot, to friction and in impacts.
    energy_residual : float
        Residual of the energy balance, over the largest of work, losses, stored energy, and energy of the peak.
    duration_s : float
        Duration of record and tail.
    end_relative_displacement_m, end_relative_velocity_m_s : float
        State at the end.
    status : int
        `damperlab.studies.variables.Status`; 0 if the integration arrived.
    loss_particle_j : float or None
        Energy lost to the friction of the particle in its cavity; None without it.
    """

    peak_relative_displacement_m: Measured
    rms_relative_displacement_m: Measured
    peak_absolute_displacement_m: Measured
    rms_absolute_displacement_m: Measured
    peak_absolute_acceleration_m_s2: Measured
    rms_absolute_acceleration_m_s2: Measured
    impacts: Count
    impact_speed_max_m_s: Measured
    stick_fraction: Measured
    work_in_j: Measured
    loss_viscous_j: Measured
    loss_friction_j: Measured
    loss_impact_j: Measured
    energy_residual: Measured
    duration_s: Measured
    end_relative_displacement_m: Measured
    end_relative_velocity_m_s: Measured
    status: Count
    loss_particle_j: float | None = None

    def values(self) -> dict[str, float | int]:
        """Return the values by name; the loss of the particle's friction is left out if there is none."""
        return {name: value for name, value in asdict(self).items() if value is not None}
