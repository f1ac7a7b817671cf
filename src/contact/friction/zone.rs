//! Contact of one step over all cells of the window, with friction.
//!
//! 1. displacements by past forces;
//! 2. required displacements d of the cells, and their slip without the forces of this step, shift = u_old + (c_1 u' +
//!    c_2 u'')/c_0 + W dt/c_0, with the cell's displacements u' and u'' one and two steps ago and the backward
//!    difference c;
//! 3. the forces (module `search`);
//! 4. slip v = (u + shift) c_0/dt, coefficients of friction and bonds of the next step; the forces join the history.
//!
//! W = (V (xi - phi y), V (alpha + phi x)) is the creep of a rigid wheel, risen over the ramp. The columns that come in
//! within two steps are carried along ahead of the window, so that cells have a history then.

use std::ops::Range;

use super::conditions::Conditions;
use super::free_creep::FreeCreep;
use super::law::CellLaw;
use super::product::Vector;
use super::search::{FrictionCounts, FrictionSearch};
use crate::contact::cells::CellHistory;
use crate::contact::complementarity::{Residuals, SearchCounts};
use crate::contact::error::ContactError;
use crate::contact::footprint::{StageMut, TangentialPart};
use crate::contact::geometry::Geometry;
use crate::contact::tread::TreadSurface;
use crate::contact::zone::{ContactZone, Instant, Solved};
use crate::counters::{Meter, Stage, Work};
use crate::numeric::largest_or_zero;
use crate::road::strip::RoadStrip;
use crate::scene::Creep;
use crate::storage::state::{Evolving, StateError, StateStream};
use crate::time_rule::TimeRule;
use crate::tyre::influence::COMPONENTS;

/// Share of mu F_z from which on a force counts as that of slip.
const FULL: f64 = 1.0 - 1e-7;

/// Motion of the wheel and the cells under it.
pub(crate) struct CellMotion {
    /// Window of the elements whose forces are reported.
    pub geometry: Geometry,
    /// Columns by which the search window is longer at either end.
    pub margin: usize,
    /// Distance of the cells across from the middle, to the left \[m\].
    pub lateral: Vec<f64>,
    /// The undeformed tread.
    pub tread: TreadSurface,
    /// Area of a cell \[m^2\].
    pub face: f64,
    /// Rolling speed \[m/s\].
    pub speed: f64,
    /// Creep of the wheel, and its present longitudinal part.
    pub creep: Creep,
    pub longitudinal: f64,
    /// Creep along that follows the torque, if the wheel rolls freely.
    pub free: Option<FreeCreep>,
    /// Time rule.
    pub rule: TimeRule,
    /// Time step \[s\].
    pub time_step: f64,
}

impl CellMotion {
    /// Columns ahead of a window of `columns` columns that are carried along: none where it is the whole tyre.
    pub(crate) fn ahead(&self, columns: usize) -> usize {
        (2 * self.geometry.advance.elements_per_step).min(self.geometry.elements - columns)
    }

    /// Slip of a step by creep over c_0 \[m\], forward and to the left, at an element and a cell across.
    fn creep(&self, step: u64, element: i64, j: usize) -> [f64; 2] {
        let (Creep { lateral, spin, ramp, .. }, longitudinal) = (&self.creep, self.longitudinal);
        let time = step as f64 * self.time_step;
        let risen = if time < *ramp { time / ramp } else { 1.0 };
        let way = risen * self.speed * self.time_step / self.rule.backward_difference()[0];
        let (x, y) = (self.geometry.position(element, step), self.lateral[j]);
        [way * (longitudinal - spin * y), way * (lateral + spin * x)]
    }
}

/// Cells of a window with friction, column by column, and of the columns before it that are carried along.
pub(crate) struct FrictionZone {
    rolling: CellMotion,
    history: Box<dyn CellHistory<COMPONENTS>>,
    search: FrictionSearch,
    law: CellLaw,
    /// Forces of the last step, then of this one \[N\], and the element that they begin with; without the pull.
    forces: Vec<Vector>,
    first_element: i64,
    required: Vec<f64>,
    shift: Vec<[f64; 2]>,
    friction: Vec<f64>,
    /// Displacements by past forces and by the pull of this step \[m\].
    old: Vec<Vector>,
    /// Forces with the pull \[N\].
    all: Vec<Vector>,
    /// Displacements by the pull \[m\]; none without adhesion.
    by_pull: Vec<Vector>,
    normal: Vec<f64>,
    /// Tangential displacements of the cells round the tyre, one and two steps ago \[m\].
    last: [Vec<[f64; 2]>; 2],
}

impl FrictionZone {
    pub(crate) fn new(
        rolling: CellMotion,
        history: Box<dyn CellHistory<COMPONENTS>>,
        search: FrictionSearch,
        law: CellLaw,
    ) -> Self {
        let cells = search.influence().cells();
        let round = rolling.geometry.elements * rolling.lateral.len();
        let zeros = || vec![[0.0; 3]; cells];
        let by_pull = if law.has_adhesion() { zeros() } else { Vec::new() };
        Self {
            history,
            search,
            law,
            forces: zeros(),
            first_element: i64::MIN,
            required: vec![0.0; cells],
            shift: vec![[0.0; 2]; cells],
            friction: vec![0.0; cells],
            old: zeros(),
            all: zeros(),
            by_pull,
            normal: vec![0.0; cells],
            last: [vec![[0.0; 2]; round], vec![[0.0; 2]; round]],
            rolling,
        }
    }

    fn across(&self) -> usize {
        self.rolling.lateral.len()
    }

    /// Cells of the window, without those ahead.
    fn window(&self) -> Range<usize> {
        0..(self.rolling.geometry.columns + 2 * self.rolling.margin) * self.across()
    }

    /// Cells that are reported.
    fn output_cells(&self) -> Range<usize> {
        let outside = self.rolling.margin * self.across();
        outside..self.window().end - outside
    }

    /// Place round the tyre of a cell of the window.
    fn place(&self, cell: usize) -> usize {
        let (across, elements) = (self.across(), self.rolling.geometry.elements as i64);
        let element = (self.first_element + (cell / across) as i64).rem_euclid(elements);
        element as usize * across + cell % across
    }

    /// Moves the guess with the window: cells are material.
    fn advance(&mut self, first_element: i64) {
        let offset = usize::try_from(first_element.saturating_sub(self.first_element)).unwrap_or(usize::MAX);
        let cells = self.forces.len();
        let offset = offset.saturating_mul(self.across()).min(cells);
        if offset > 0 {
            self.forces.copy_within(offset.., 0);
            self.forces[cells - offset..].fill([0.0; 3]);
        }
        self.first_element = first_element;
    }

    /// Sets up required displacements, slips and coefficients of friction of a step.
    fn set_up(&mut self, at: &Instant<'_>, road: &RoadStrip) {
        let across = self.across();
        let [now, one, two] = self.rolling.rule.backward_difference();
        let window = self.window().end;
        for cell in 0..self.forces.len() {
            let (place, column, j) = (self.place(cell), cell / across, cell % across);
            let element = at.first_element + column as i64;
            let height = road.heights(element).map(|heights| heights[j]).filter(|_| cell < window);
            self.required[cell] = height.map_or(f64::NEG_INFINITY, |height| {
                at.indentation - at.rises[column] - self.rolling.tread.row(element)[j] + height - self.old[cell][2]
            });
            let creep = self.rolling.creep(at.step, element, j);
            let last = [0, 1].map(|ago: usize| self.last[ago][place]);
            self.shift[cell] = [0, 1].map(|component: usize| {
                let previous = one * last[0][component] + two * last[1][component];
                self.old[cell][component] + previous / now + creep[component]
            });
            self.friction[cell] = self.law.friction(place);
        }
    }

    /// Applies the bonds of this step: the pull, and the displacements by it.
    fn pull(&mut self) {
        self.all.fill([0.0; 3]);
        if !self.law.has_adhesion() {
            return;
        }
        let face = self.rolling.face;
        for cell in self.window() {
            self.all[cell][2] = -self.law.pull(self.place(cell)) * face;
        }
        self.search.displace(&self.all, &mut self.by_pull);
        for (old, by_pull) in self.old.iter_mut().zip(&self.by_pull) {
            old.iter_mut().zip(by_pull).for_each(|(old, by_pull)| *old += by_pull);
        }
    }

    /// Updates the states by the forces of a step: displacements, coefficients, bonds and creep; writes the tangential
    /// part.
    fn follow(&mut self, step: u64, out: Option<&mut TangentialPart>) {
        let (across, output_cells, window) = (self.across(), self.output_cells(), self.window().end);
        let rate = self.rolling.rule.backward_difference()[0] / self.rolling.time_step;
        let mut part = TangentialPart::default();
        self.last.swap(0, 1);
        let mut out = out;
        if let Some(out) = &mut out {
            out.forces.fill([0.0; 2]);
            out.slip.fill([0.0; 2]);
        }
        let ends = [0, output_cells.len().saturating_sub(across)];
        for cell in 0..self.forces.len() {
            let (place, displacement) = (self.place(cell), self.search.displacements()[cell]);
            self.last[0][place] = [0, 1].map(|component| displacement[component] + self.old[cell][component]);
            let force = self.forces[cell];
            let slip = [0, 1].map(|component| (displacement[component] + self.shift[cell][component]) * rate);
            let (speed, is_pressed) = (slip[0].hypot(slip[1]), force[2] > 0.0);
            let gap = displacement[2] - self.required[cell];
            part.bonded += usize::from(cell < window && self.law.pull(place) > 0.0);
            self.law.follow(place, is_pressed.then_some(speed), gap);
            if !is_pressed {
                continue;
            }
            let bound = self.friction[cell] * force[2];
            let element = self.first_element + (cell / across) as i64;
            let creep = self.rolling.creep(step, element, cell % across);
            // Slip less creep is the surface's motion.
            part.power += (0..2).map(|axis| force[axis] * (slip[axis] - rate * creep[axis])).sum::<f64>();
            let is_slipping = force[0].hypot(force[1]) >= FULL * bound;
            part.slipping += usize::from(is_slipping);
            part.sticking += usize::from(!is_slipping);
            // Slip of a cell that sticks is rounding.
            let slip = if is_slipping { slip } else { [0.0; 2] };
            part.slip_power += if is_slipping { bound * speed } else { 0.0 };
            let (x, y) = (self.rolling.geometry.position(element, step), self.rolling.lateral[cell % across]);
            part.aligning_moment += x * force[1] - y * force[0];
            part.total[0] += force[0];
            part.total[1] += force[1];
            part.torque += self.rolling.geometry.radius * force[0] + x * self.normal[cell];
            let Some(out) = &mut out else { continue };
            // Forces beyond the reported columns go to the outermost of these.
            let place = match cell {
                _ if cell < output_cells.start => ends[0] + cell % across,
                _ if cell >= output_cells.end => ends[1] + cell % across,
                _ => cell - output_cells.start,
            };
            out.forces[place][0] += force[0];
            out.forces[place][1] += force[1];
            out.slip[place] = slip;
        }
        part.creep = self.rolling.longitudinal;
        if let Some(free) = &mut self.rolling.free {
            free.follow(step, part.torque / self.rolling.geometry.radius);
            self.rolling.longitudinal = free.creep();
        }
        if let Some(out) = out {
            let (forces, slip) = (std::mem::take(&mut out.forces), std::mem::take(&mut out.slip));
            *out = TangentialPart { forces, slip, ..part };
        }
    }
}

impl ContactZone for FrictionZone {
    fn solve(
        &mut self,
        at: Instant<'_>,
        road: &RoadStrip,
        mut output: StageMut<'_>,
        meter: &mut Meter,
    ) -> Result<Solved, ContactError> {
        let Instant { step, stage, first_element, .. } = at;
        if !road.has_heights() {
            return Err(ContactError::RoadForm);
        }
        let mut laps = meter.laps();
        self.advance(first_element);
        self.old.fill([0.0; 3]);
        self.history.add_displacement(stage, first_element, &mut self.old, meter);
        meter.lap(&mut laps, Stage::History);
        self.pull();
        self.set_up(&at, road);
        let cells = self.forces.len() as u64;
        meter.add_work(Stage::Penetration, Work { multiply_adds: 20 * cells, bytes: 200 * cells });
        meter.lap(&mut laps, Stage::Penetration);
        let has_no_nan = self.required.iter().all(|required| !required.is_nan());
        let conditions = Conditions { required: &self.required, shift: &self.shift, friction: &self.friction };
        let relative = self.search.solve(&conditions, &mut self.forces);
        let largest_force = self.forces.iter().fold(0.0_f64, |largest, force| largest.max(force[2]));
        if self.search.is_unsettled() && has_no_nan {
            let points = self.forces.iter().filter(|force| force[2] > 0.0).count();
            let friction = largest_or_zero(&self.friction);
            return Err(ContactError::FrictionUnsettled { points, friction, step });
        }
        meter.lap(&mut laps, Stage::ActiveSet);
        for (all, force) in self.all.iter_mut().zip(&self.forces) {
            // The pull adds to the pressure.
            *all = [force[0], force[1], force[2] + all[2]];
        }
        self.normal.iter_mut().zip(&self.all).for_each(|(normal, all)| *normal = all[2]);
        let is_seen = self.history.push(stage, first_element, &self.all);
        meter.lap(&mut laps, Stage::History);
        self.follow(step, output.tangential.as_deref_mut());
        let (window, across) = (self.window(), self.across());
        let (old, u) = (&self.old, self.search.displacements());
        let displacement = |cell: usize| old[cell][2] + u[cell][2];
        output.write(
            self.output_cells(),
            across,
            &self.normal[window.clone()],
            &self.required[window.clone()],
            displacement,
        );
        let is_touched = |column: Option<&[Vector]>| column.is_some_and(|cells| cells.iter().any(|f| f[2] > 0.0));
        let mut columns = self.forces[window].chunks_exact(across);
        let is_at_end = is_touched(columns.next()) || is_touched(columns.next_back()) || !is_seen;
        let largest_displacement = largest_or_zero(&self.required);
        let residuals = Residuals {
            tension: 0.0,
            penetration: relative.normal * largest_displacement,
            complementarity: relative.normal.max(relative.tangential) * largest_displacement * largest_force,
        };
        Ok(Solved { residuals, largest_force, largest_displacement, has_no_nan, is_at_end })
    }

    fn across(&self) -> usize {
        self.rolling.lateral.len()
    }

    fn margin(&self) -> usize {
        self.rolling.margin
    }

    fn is_widened(&self) -> bool {
        true
    }

    fn has_friction(&self) -> bool {
        true
    }

    fn first_weights(&self) -> &[f64] {
        self.search.influence().pairs.last().map_or(&[], |pair| &pair.toeplitz)
    }

    fn search_counts(&self) -> SearchCounts {
        let FrictionCounts { steps, rounds, work, .. } = self.search.counts();
        SearchCounts { solves: steps, fallbacks: rounds, work, ..SearchCounts::default() }
    }
}

impl Evolving for FrictionZone {
    fn state(&mut self, state: &mut StateStream<'_>) -> Result<(), StateError> {
        let Self { rolling, history, search, law, forces, first_element, last, .. } = self;
        state.all([history, search, law, forces, first_element, last, &mut rolling.free])?;
        if let Some(free) = &rolling.free {
            rolling.longitudinal = free.creep();
        }
        Ok(())
    }
}
