//! The services of a run: names, types, sizes, and the check that both ends agree.

use std::fmt::Debug;

use iceoryx2::prelude::*;
use iceoryx2::service::port_factory::{event, publish_subscribe};

use super::rendezvous::{Rendezvous, compare};
use super::watch::Member;
use crate::message::{Command, Header, Record, Status};
use crate::participant::{ExchangeError, Role};

/// Attribute that carries [`crate::message::PROTOCOL_VERSION`] in decimal.
pub const PROTOCOL_ATTRIBUTE: &str = "bedload.protocol";
/// Attribute that carries [`crate::message::layout_hash`] in 16 hexadecimal digits.
pub const LAYOUT_ATTRIBUTE: &str = "bedload.layout";
/// Attribute that carries the number of grains in decimal.
pub const GRAINS_ATTRIBUTE: &str = "bedload.grains";

pub(crate) type Records<R> = publish_subscribe::PortFactory<ipc::Service, [R], Header>;
pub(crate) type Single<R> = publish_subscribe::PortFactory<ipc::Service, R, ()>;

/// Shared memory that the buffers of one topic of data may fill, bytes.
const BUFFER_BYTES: usize = 8 << 20;

/// Messages of loads or kinematics that a subscriber may read at once.
const BORROWED: usize = 2;

/// Turns an iceoryx2 error into ours, saying what failed.
pub(crate) fn transport<E: Debug>(what: &str) -> impl Fn(E) -> ExchangeError {
    move |error| ExchangeError::Transport(format!("{what}: {error:?}"))
}

/// Messages that a subscriber of loads or kinematics may lag behind: 16 for small runs, 2 for large.
pub(crate) fn depth<R: Record>(grains: usize) -> usize {
    (BUFFER_BYTES / (grains.max(1) * size_of::<R>())).clamp(2, 16)
}

/// Messages of a topic of data that may be lent out at once: two subscribers, each with what waits and what
/// it reads, and the publisher's own.
pub(crate) fn most_lent(depth: usize) -> usize {
    2 * (depth + BORROWED) + 1
}

/// `bedload/loads` or `bedload/kinematics`.
fn name_of<R: Record>() -> String {
    format!("bedload/{}", R::NAME.to_lowercase())
}

fn service_name(name: &str) -> Result<ServiceName, ExchangeError> {
    name.try_into().map_err(transport(name))
}

/// What the rendezvous says about this build ([`Rendezvous::parse`] has compared it with ours).
fn attributes(rendezvous: &Rendezvous) -> [(&'static str, String); 3] {
    [
        (PROTOCOL_ATTRIBUTE, rendezvous.protocol.to_string()),
        (LAYOUT_ATTRIBUTE, rendezvous.layout.clone()),
        (GRAINS_ATTRIBUTE, rendezvous.grains.to_string()),
    ]
}

fn specifier(rendezvous: &Rendezvous) -> Result<AttributeSpecifier, ExchangeError> {
    let mut all = AttributeSpecifier::new();
    for (key, value) in attributes(rendezvous) {
        let key = key.try_into().map_err(transport("attribute"))?;
        let value = value.as_str().try_into().map_err(transport("attribute"))?;
        all = all.define(&key, &value).map_err(transport("attribute"))?;
    }
    Ok(all)
}

/// Compares the attributes of an existing service with ours before it is opened: iceoryx2 itself
/// compares only name, size and alignment of the types, and does not say what differs.
fn verify(
    node: &Node<ipc::Service>,
    rendezvous: &Rendezvous,
    name: &str,
    pattern: MessagingPattern,
) -> Result<(), ExchangeError> {
    let found = ipc::Service::details(&service_name(name)?, node.config(), pattern)
        .map_err(transport(name))?
        .ok_or_else(|| {
            ExchangeError::Transport(format!("{name} does not exist: is bedload still running?"))
        })?;
    let theirs = found.static_details.attributes();
    for (key, ours) in attributes(rendezvous) {
        let key_there = key.try_into().map_err(transport("attribute"))?;
        let there = theirs.key_value(&key_there, 0).map_or("none".to_owned(), ToString::to_string);
        compare(Member::Coupler, key, there, ours)?;
    }
    Ok(())
}

/// Creates (coupler) or opens (solver) the topic of `R`, one slice per window.
pub(crate) fn records<R: Record + ZeroCopySend>(
    node: &Node<ipc::Service>,
    rendezvous: &Rendezvous,
    own: Member,
) -> Result<Records<R>, ExchangeError> {
    let name = name_of::<R>();
    let builder =
        node.service_builder(&service_name(&name)?).publish_subscribe::<[R]>().user_header::<Header>();
    if own != Member::Coupler {
        verify(node, rendezvous, &name, MessagingPattern::PublishSubscribe)?;
        return builder.open().map_err(transport(&name));
    }
    builder
        .enable_safe_overflow(false)
        .history_size(0)
        .max_publishers(1)
        .max_subscribers(2)
        .max_nodes(3)
        .subscriber_max_buffer_size(depth::<R>(rendezvous.grains))
        .subscriber_max_borrowed_samples(BORROWED)
        .create_with_attributes(&specifier(rendezvous)?)
        .map_err(transport(&name))
}

/// Creates or opens a topic of single records with one publisher.
fn single<R: Record + ZeroCopySend>(
    node: &Node<ipc::Service>,
    rendezvous: &Rendezvous,
    own: Member,
    name: &str,
    subscribers: usize,
    buffer: usize,
) -> Result<Single<R>, ExchangeError> {
    let builder = node.service_builder(&service_name(name)?).publish_subscribe::<R>();
    if own != Member::Coupler {
        verify(node, rendezvous, name, MessagingPattern::PublishSubscribe)?;
        return builder.open().map_err(transport(name));
    }
    builder
        .enable_safe_overflow(false)
        .history_size(0)
        .max_publishers(1)
        .max_subscribers(subscribers)
        .max_nodes(3)
        .subscriber_max_buffer_size(buffer)
        .subscriber_max_borrowed_samples(1)
        .create_with_attributes(&specifier(rendezvous)?)
        .map_err(transport(name))
}

/// `bedload/command`, coupler → every solver. Room for an `Accept` after each window ordered ahead.
pub(crate) fn commands(
    node: &Node<ipc::Service>,
    rendezvous: &Rendezvous,
    own: Member,
) -> Result<Single<Command>, ExchangeError> {
    let (solvers, buffer) = (rendezvous.roles.len(), 2 * rendezvous.ahead + 4);
    single(node, rendezvous, own, "bedload/command", solvers, buffer)
}

/// `bedload/status/fluid` and `bedload/status/dem`, solver → coupler.
pub(crate) fn status(
    node: &Node<ipc::Service>,
    rendezvous: &Rendezvous,
    own: Member,
    role: Role,
) -> Result<Single<Status>, ExchangeError> {
    let name = format!("bedload/status/{role}");
    single(node, rendezvous, own, &name, 1, rendezvous.ahead + 8)
}

/// `bedload/wake/coupler`, `bedload/wake/fluid`, `bedload/wake/dem`: the bell of each process.
pub(crate) fn event(
    node: &Node<ipc::Service>,
    whose: Member,
) -> Result<event::PortFactory<ipc::Service>, ExchangeError> {
    let name = format!("bedload/wake/{}", whose.node_name());
    node.service_builder(&service_name(&name)?)
        .event()
        .max_nodes(3)
        .max_listeners(1)
        .max_notifiers(2)
        .event_id_max_value(0)
        .open_or_create()
        .map_err(transport(&name))
}

/// This process's node in the run.
pub(crate) fn node(rendezvous: &Rendezvous, own: Member) -> Result<Node<ipc::Service>, ExchangeError> {
    set_log_level_from_env_or(LogLevel::Fatal);
    let config = super::watch::config_of(&rendezvous.root, &rendezvous.prefix)?;
    let name = own.node_name().try_into().map_err(transport("node name"))?;
    NodeBuilder::new()
        .name(&name)
        .config(&config)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<ipc::Service>()
        .map_err(transport("cannot join the run's iceoryx2 domain"))
}
