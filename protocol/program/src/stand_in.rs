//! The absent partner of a solver in this process: a function of the scene, or the messages of a log.

use protocol::message::{Header, Record};
use protocol::participant::{Exchange, ExchangeError, Window};

/// What the absent peer would send in a window.
pub type Answer<R> = Box<dyn Fn(&Window, &mut [R]) + Send>;

/// The exchange of a solver alone: takes what it sends, gives it the answer.
pub struct StandIn<In: Record, Out: Record> {
    pub(crate) answer: Option<Answer<In>>,
    /// A message from a log, in place of the answer.
    pub(crate) given: Option<Header>,
    pub(crate) incoming: Vec<In>,
    pub(crate) outgoing: Vec<Out>,
    pub(crate) header: Header,
    /// Window and attempt in which it sent last, and received last.
    pub(crate) sent: Option<(u64, u64)>,
    pub(crate) received: Option<(u64, u64)>,
}

impl<In: Record, Out: Record> StandIn<In, Out> {
    /// For `grains` grains, with `answer` in place of the peer.
    pub fn new(grains: usize, answer: Answer<In>) -> Self {
        Self { answer: Some(answer), ..Self::of_log(grains) }
    }

    /// For `grains` grains, with the messages of a log in place of the peer.
    pub(crate) fn of_log(grains: usize) -> Self {
        Self {
            answer: None,
            given: None,
            incoming: vec![In::default(); grains],
            outgoing: vec![Out::default(); grains],
            header: Header::default(),
            sent: None,
            received: None,
        }
    }

    /// What the solver sent in the last window.
    pub fn outgoing(&self) -> (&Header, &[Out]) {
        (&self.header, &self.outgoing)
    }

    /// Begins a window, with the peer's message if the log has one.
    pub(crate) fn begin(&mut self, given: Option<(Header, Vec<In>)>) {
        (self.sent, self.received) = (None, None);
        self.given = given.map(|(header, records)| {
            self.incoming = records;
            header
        });
    }
}

impl<In: Record, Out: Record> Exchange<In, Out> for StandIn<In, Out> {
    fn send(&mut self, header: Header, fill: &mut dyn FnMut(&mut [Out])) -> Result<(), ExchangeError> {
        let window = Some((header.step, header.attempt));
        if std::mem::replace(&mut self.sent, window) == window {
            let what = format!("{} sent twice in window {}", Out::NAME, header.step);
            return Err(ExchangeError::Order(what));
        }
        self.header = header;
        fill(&mut self.outgoing);
        Ok(())
    }

    fn receive(
        &mut self,
        window: &Window,
        read: &mut dyn FnMut(&Header, &[In]),
    ) -> Result<(), ExchangeError> {
        let asked = Some((window.step, window.attempt));
        if std::mem::replace(&mut self.received, asked) == asked {
            let what = format!("{} asked for twice in window {}", In::NAME, window.step);
            return Err(ExchangeError::Order(what));
        }
        match (&self.given, &self.answer) {
            (Some(header), _) if Some((header.step, header.attempt)) != asked => {
                let what = format!(
                    "window {} attempt {} asked for, the log is at {} attempt {}",
                    window.step, window.attempt, header.step, header.attempt
                );
                return Err(ExchangeError::Order(what));
            }
            (Some(header), _) => read(header, &self.incoming),
            (None, Some(answer)) => {
                answer(window, &mut self.incoming);
                read(&window.header(), &self.incoming);
            }
            (None, None) => {
                let what = format!("the log has no {}: that solver took no part", In::NAME);
                return Err(ExchangeError::Order(what));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use protocol::message::{Kinematics, Loads};

    fn window(step: u64) -> Window {
        Window { step, attempt: 0, time: 0.0, dt: 0.1, substeps: 1, output: false }
    }

    fn receive(exchange: &mut StandIn<Loads, Kinematics>, step: u64) -> Result<f64, ExchangeError> {
        let mut force = f64::NAN;
        exchange.receive(&window(step), &mut |_, loads| force = loads[0].force[2])?;
        Ok(force)
    }

    #[test]
    fn an_exchange_out_of_turn_is_refused() {
        let mut exchange = StandIn::<Loads, Kinematics>::of_log(1);
        assert!(receive(&mut exchange, 0).is_err(), "neither a message nor an answer");
        let logged =
            |step| Some((window(step).header(), vec![Loads { force: [0.0, 0.0, 2.0], ..Loads::default() }]));
        exchange.begin(logged(0));
        assert!(receive(&mut exchange, 1).is_err(), "another window");
        exchange.begin(logged(0));
        assert_eq!(receive(&mut exchange, 0).expect("the logged message"), 2.0);
        assert!(receive(&mut exchange, 0).is_err(), "twice");
        let send = |exchange: &mut StandIn<Loads, Kinematics>, step| {
            Exchange::<Loads, Kinematics>::send(exchange, window(step).header(), &mut |_| {})
        };
        assert!(send(&mut exchange, 0).is_ok());
        assert!(send(&mut exchange, 0).is_err(), "twice");
        assert!(send(&mut exchange, 1).is_ok());
        let mut alone =
            StandIn::<Loads, Kinematics>::new(1, Box::new(|window, loads| loads[0].force[2] = window.dt));
        assert_eq!(receive(&mut alone, 7).expect("the answer"), 0.1);
    }
}
