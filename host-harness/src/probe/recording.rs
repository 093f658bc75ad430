//! From a drive's frames to a log that `discover` reads, with the estimates beside the measurements.

use std::f64::consts::TAU;

use joint_core::telemetry::frame::{Frame, Reader};
use joint_core::telemetry::{
    CaptureHead, Hello, Message, Mode, Quantities, Report, Sample, Status,
};

/// What a drive has sent.
#[derive(Clone, Debug, Default)]
pub struct Recording {
    reader: Reader,
    next: Option<u32>,
    /// Frames that are missing in between.
    pub lost: u64,
    /// Messages that the drive itself had to drop.
    pub dropped: u32,
    /// Who is speaking, as last said.
    pub hello: Option<Hello>,
    /// Every report.
    pub reports: Vec<Report>,
    head: Option<CaptureHead>,
    samples: Vec<Option<Sample>>,
}

impl Recording {
    /// Takes in what has arrived.
    pub fn take(&mut self, bytes: &[u8]) {
        for byte in bytes {
            let mut frame = self.reader.push(*byte);
            while let Some(found) = frame {
                self.frame(found);
                frame = self.reader.rest();
            }
        }
    }

    fn frame(&mut self, frame: Frame) {
        if let Some(next) = self.next {
            self.lost += u64::from(frame.sequence.wrapping_sub(next));
        }
        self.next = Some(frame.sequence.wrapping_add(1));
        match frame.message {
            Message::Hello(hello) => self.hello = Some(hello),
            Message::Report(report) => self.reports.push(report),
            Message::Dropped(count) => self.dropped = count,
            Message::CaptureHead(head) => {
                self.head = Some(head);
                self.samples = vec![None; head.samples as usize];
            }
            Message::Samples(first, samples) => {
                for (place, sample) in self.samples.iter_mut().skip(first as usize).zip(samples) {
                    *place = Some(sample);
                }
            }
            _ => {}
        }
    }

    /// Bytes that belonged to no whole frame.
    pub fn skipped(&self) -> u32 {
        self.reader.skipped
    }

    /// Whether every sample of the last capture has arrived; none where there was no capture.
    pub fn capture_is_whole(&self) -> Option<bool> {
        self.head.map(|_| self.samples.iter().all(Option::is_some))
    }

    /// The last capture's head.
    pub fn capture_head(&self) -> Option<CaptureHead> {
        self.head
    }

    /// The reports as a log: time, measurements, then the estimates under the names that `joint
    /// observe` gives them, and the status in words. Nothing without a [`Hello`], which has the
    /// scales.
    pub fn log(&self) -> Option<Vec<(String, Vec<f64>)>> {
        let hello = self.hello?;
        let first = self.reports.first().map_or(0, |report| report.tick);
        let rows: Vec<(u32, Sample)> = self
            .reports
            .iter()
            .map(|report| (report.tick.wrapping_sub(first), report.sample))
            .collect();
        let mut columns = measured(&hello, &rows);
        let stages = usize::from(hello.stages);
        let mut push = |name: String, of: &dyn Fn(&Report) -> f32| {
            columns.push((name, self.reports.iter().map(|own| f64::from(of(own))).collect()));
        };
        type Part = fn(&Report) -> &Quantities;
        let parts: [(Part, &str); 2] =
            [(|report| &report.estimates, ""), (|report| &report.deviations, "_std")];
        for (part, end) in parts {
            let mut own = |name: &str, of: fn(&Quantities) -> f32| {
                push(format!("{name}{end}"), &|report| of(part(report)));
            };
            own("motor_velocity_rad_per_s", |q| q.motor_velocity_rad_per_s);
            own("total_friction_at_motor_nm", |q| q.total_friction_at_motor_nm);
            own("estimated_output_angle_rad", |q| q.output_angle_rad);
            own("output_velocity_rad_per_s", |q| q.output_velocity_rad_per_s);
            own("estimated_load_torque_nm", |q| q.load_torque_nm);
            for stage in 0..stages.min(joint_core::telemetry::MAX_STAGES) {
                let name = format!("stage{}_windup_rad{end}", stage + 1);
                push(name, &|report| part(report).windup_rad[stage]);
            }
        }
        push("status".to_owned(), &|report| f32::from(report.status.0));
        push("health".to_owned(), &|report| f32::from(report.health));
        Some(columns)
    }

    /// The last capture as a log, with a gap where samples are missing.
    pub fn capture(&self) -> Option<Vec<(String, Vec<f64>)>> {
        let (hello, _) = (self.hello?, self.head?);
        let rows: Vec<(u32, Sample)> =
            (0..).zip(&self.samples).filter_map(|(k, sample)| Some((k, (*sample)?))).collect();
        Some(measured(&hello, &rows))
    }

    /// The latest report in a line, for a terminal.
    pub fn line(&self) -> String {
        let Some(report) = self.reports.last() else { return "no report yet".to_owned() };
        let q = &report.estimates;
        format!(
            "{:>9} {:8.3} V {:8.4} A {:9.2} rad/s friction {:10.3e} Nm load {:10.3e} Nm {}",
            report.tick,
            report.sample.voltage_v,
            report.sample.current_a,
            q.motor_velocity_rad_per_s,
            q.total_friction_at_motor_nm,
            q.load_torque_nm,
            status(report.status),
        )
    }
}

/// The columns of a log of these samples, each with the tick it was taken at.
fn measured(hello: &Hello, rows: &[(u32, Sample)]) -> Vec<(String, Vec<f64>)> {
    // The period is a round number of nanoseconds, which single precision blurs.
    let period_s = (f64::from(hello.sample_time_s) * 1e9).round() * 1e-9;
    let column = |name: &str, of: &dyn Fn(&(u32, Sample)) -> f64| {
        (name.to_owned(), rows.iter().map(of).collect::<Vec<f64>>())
    };
    // As single precision prints, not with the digits of its exact value.
    let short = |value: f32| value.to_string().parse().unwrap_or(f64::NAN);
    let turn = |counts: i32, per_turn: u32| f64::from(counts) / f64::from(per_turn.max(1)) * TAU;
    let mut columns = vec![
        column("t_s", &|(tick, _)| f64::from(*tick) * period_s),
        column("u_v", &|(_, sample)| short(sample.voltage_v)),
        column("i_a", &|(_, sample)| short(sample.current_a)),
        column("motor_angle_rad", &|(_, sample)| {
            turn(sample.motor_counts, hello.motor_counts_per_turn)
        }),
    ];
    if hello.output_counts_per_turn > 0 {
        columns.push(column("output_angle_rad", &|(_, sample)| {
            turn(sample.output_counts, hello.output_counts_per_turn)
        }));
    }
    columns
}

/// A status in words.
pub fn status(status: Status) -> String {
    let names = Status::NAMES.iter().filter(|(flag, _)| status.meets(*flag)).map(|(_, name)| *name);
    names.collect::<Vec<_>>().join(", ")
}

/// Who is speaking, in a line.
pub fn greeting(hello: &Hello) -> String {
    let period_us = f64::from(hello.sample_time_s) * 1e6;
    match hello.mode {
        Mode::Parameters => format!(
            "parameters {:08x}, {} stages, {period_us:.1} µs a period",
            hello.parameters_crc, hello.stages
        ),
        Mode::Defaults => format!(
            "listening with the defaults: parameters refused ({}), {period_us:.1} µs a period",
            firmware::block::BlockError::of_code(hello.refusal)
        ),
    }
}
