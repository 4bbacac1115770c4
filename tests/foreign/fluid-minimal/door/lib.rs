//! iceoryx2 for a C program: one node and its ports (door.h). It knows nothing of Bedload.

// What each function takes stands in door.h.
#![allow(clippy::missing_safety_doc)]

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::fmt::Debug;
use std::mem::MaybeUninit;
use std::ptr::{null, null_mut};
use std::time::Duration;

use iceoryx2::node::NodeView;
use iceoryx2::port::listener::{Listener, ListenerWaitError};
use iceoryx2::port::notifier::Notifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::*;
use iceoryx2::sample::Sample;
use iceoryx2::sample_mut_uninit::SampleMutUninit;
use iceoryx2::service::marker::{CustomHeaderMarker, CustomPayloadMarker};
use iceoryx2::service::port_factory::{event, publish_subscribe};
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};

// What iceoryx2's own bindings use for types that only the caller knows.
type Bytes = [CustomPayloadMarker];
type Head = CustomHeaderMarker;
type Opened = publish_subscribe::PortFactory<ipc::Service, Bytes, Head>;
type Loan = SampleMutUninit<ipc::Service, [MaybeUninit<CustomPayloadMarker>], Head>;

struct Out {
    loan: Option<Loan>,
    port: Publisher<ipc::Service, Bytes, Head>,
    service: Opened,
    has_header: bool,
}

struct In {
    held: Option<Sample<ipc::Service, Bytes, Head>>,
    port: Subscriber<ipc::Service, Bytes, Head>,
    service: Opened,
    has_header: bool,
}

/// The ports go before the node.
pub struct Door {
    publishers: Vec<Out>,
    subscribers: Vec<In>,
    notifiers: Vec<Notifier<ipc::Service>>,
    listeners: Vec<Listener<ipc::Service>>,
    node: Node<ipc::Service>,
}

#[repr(C)]
pub struct Topic {
    service: *const c_char,
    type_name: *const c_char,
    size: usize,
    slice: c_int,
    header: *const c_char,
    header_size: usize,
}

type Done<T> = Result<T, String>;

thread_local! {
    static ERROR: RefCell<CString> = RefCell::default();
}

/// The result of a call, or `failed` with its error kept for `door_error`.
fn tell<T>(failed: T, result: Done<T>) -> T {
    result.unwrap_or_else(|error| {
        ERROR.with(|kept| *kept.borrow_mut() = CString::new(error).unwrap_or_default());
        failed
    })
}

fn why<E: Debug>(what: &str) -> impl Fn(E) -> String {
    move |error| format!("iceoryx2: {what}: {error:?}")
}

/// # Safety
/// `text` is a C string that outlives its use.
unsafe fn text<'a>(text: *const c_char) -> Done<&'a str> {
    unsafe { CStr::from_ptr(text) }.to_str().map_err(why("text"))
}

/// # Safety
/// `door` comes from `door_open`.
unsafe fn of<'a>(door: *mut Door) -> &'a mut Door {
    unsafe { &mut *door }
}

fn port<T>(ports: &mut [T], index: c_int) -> Done<&mut T> {
    usize::try_from(index).ok().and_then(|index| ports.get_mut(index)).ok_or_else(|| "no such port".into())
}

/// Keeps a port and returns its number.
fn keep<T>(ports: &mut Vec<T>, port: T) -> c_int {
    ports.push(port);
    ports.len() as c_int - 1
}

#[unsafe(no_mangle)]
pub extern "C" fn door_error() -> *const c_char {
    ERROR.with(|kept| kept.borrow().as_ptr())
}

fn open(root: &str, prefix: &str, name: &str) -> Done<Node<ipc::Service>> {
    set_log_level_from_env_or(LogLevel::Fatal);
    let mut config = Config::default();
    config.global.set_root_path(&iceoryx2::prelude::Path::new(root.as_bytes()).map_err(why(root))?);
    config.global.prefix = FileName::new(prefix.as_bytes()).map_err(why(prefix))?;
    config.global.service.cleanup_dead_nodes_on_open = false;
    config.global.node.cleanup_dead_nodes_on_creation = false;
    config.global.node.cleanup_dead_nodes_on_destruction = false;
    let name = NodeName::new(name).map_err(why(name))?;
    let builder = NodeBuilder::new().name(&name).config(&config);
    builder.signal_handling_mode(SignalHandlingMode::Disabled).create().map_err(why("cannot make the node"))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_open(
    root: *const c_char,
    prefix: *const c_char,
    name: *const c_char,
) -> *mut Door {
    let node = || unsafe { open(text(root)?, text(prefix)?, text(name)?) };
    let door = |node| {
        let (publishers, subscribers, notifiers, listeners) = Default::default();
        Box::into_raw(Box::new(Door { publishers, subscribers, notifiers, listeners, node }))
    };
    tell(null_mut(), node().map(door))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_close(door: *mut Door) {
    drop(unsafe { Box::from_raw(door) });
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_process(door: *mut Door, name: *const c_char) -> c_int {
    let find = || {
        let (door, name) = unsafe { (of(door), text(name)?) };
        let mut process = 0;
        let look = |state| {
            if let NodeState::Alive(view) = &state
                && let Some(details) = NodeView::details(view)
                && details.name().as_str() == name
            {
                process = details.process_id().value() as c_int;
            }
            CallbackProgression::Continue
        };
        Node::<ipc::Service>::list(door.node.config(), look).map_err(why("cannot list the nodes"))?;
        Ok(process)
    };
    tell(-1, find())
}

fn attribute(node: &Node<ipc::Service>, service: &str, key: &str) -> Done<String> {
    let name = ServiceName::new(service).map_err(why(service))?;
    let details = ipc::Service::details(&name, node.config(), MessagingPattern::PublishSubscribe);
    let details = details.map_err(why(service))?.ok_or_else(|| format!("{service} does not exist"))?;
    let attribute = key.try_into().map_err(why(key))?;
    let value = details.static_details.attributes().key_value(&attribute, 0).map(ToString::to_string);
    value.ok_or_else(|| format!("{service} has no attribute {key}"))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_attribute(
    door: *mut Door,
    service: *const c_char,
    key: *const c_char,
    value: *mut c_char,
    room: usize,
) -> c_int {
    let copy = || unsafe {
        let found =
            CString::new(attribute(&of(door).node, text(service)?, text(key)?)?).map_err(why("value"))?;
        let bytes = found.as_bytes_with_nul();
        if bytes.len() > room {
            return Err(format!("{found:?} does not fit into {room} bytes"));
        }
        value.cast::<u8>().copy_from_nonoverlapping(bytes.as_ptr(), bytes.len());
        Ok(0)
    };
    tell(-1, copy())
}

/// # Safety
/// `topic` is one of door.h.
unsafe fn service(node: &Node<ipc::Service>, topic: *const Topic) -> Done<(Opened, bool)> {
    let topic = unsafe { &*topic };
    let service = unsafe { text(topic.service) }?;
    let detail = |variant, name: *const c_char, size| {
        let name = unsafe { text(name) }?;
        TypeDetail::__internal_new_from_parts(variant, name, size, align_of::<u64>()).map_err(why(name))
    };
    let variant = if topic.slice == 0 { TypeVariant::FixedSize } else { TypeVariant::Dynamic };
    let payload = detail(variant, topic.type_name, topic.size)?;
    let header = match topic.header.is_null() {
        true => TypeDetail::new::<()>(TypeVariant::FixedSize),
        false => detail(TypeVariant::FixedSize, topic.header, topic.header_size)?,
    };
    let name = ServiceName::new(service).map_err(why(service))?;
    let builder = node.service_builder(&name).publish_subscribe::<Bytes>().user_header::<Head>();
    let builder = unsafe {
        builder.__internal_set_payload_type_details(&payload).__internal_set_user_header_type_details(&header)
    };
    Ok((builder.open().map_err(why(service))?, !topic.header.is_null()))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_publisher(door: *mut Door, topic: *const Topic, longest: usize) -> c_int {
    let make = || {
        let door = unsafe { of(door) };
        let (service, has_header) = unsafe { service(&door.node, topic) }?;
        let builder = service.publisher_builder().max_loaned_samples(1);
        // A full queue is an error, not a wait without a limit.
        let builder = builder.backpressure_strategy(BackpressureStrategy::DiscardData);
        let builder = builder.initial_max_slice_len(longest.max(1));
        let port = builder.create().map_err(why("cannot publish"))?;
        Ok(keep(&mut door.publishers, Out { loan: None, port, service, has_header }))
    };
    tell(-1, make())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_subscriber(door: *mut Door, topic: *const Topic) -> c_int {
    let make = || {
        let door = unsafe { of(door) };
        let (service, has_header) = unsafe { service(&door.node, topic) }?;
        let port = service.subscriber_builder().create().map_err(why("cannot subscribe"))?;
        Ok(keep(&mut door.subscribers, In { held: None, port, service, has_header }))
    };
    tell(-1, make())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_subscribers(door: *mut Door, publisher: c_int) -> c_int {
    let out = port(unsafe { &mut of(door).publishers }, publisher);
    tell(-1, out.map(|out| out.service.dynamic_config().number_of_subscribers() as c_int))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_publishers(door: *mut Door, subscriber: c_int) -> c_int {
    let from = port(unsafe { &mut of(door).subscribers }, subscriber);
    tell(-1, from.map(|from| from.service.dynamic_config().number_of_publishers() as c_int))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_connect(door: *mut Door) -> c_int {
    let door = unsafe { of(door) };
    let publishers = door.publishers.iter().try_for_each(|out| out.port.update_connections());
    let all =
        publishers.and_then(|()| door.subscribers.iter().try_for_each(|from| from.port.update_connections()));
    tell(-1, all.map(|()| 0).map_err(why("cannot connect")))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_loan(
    door: *mut Door,
    publisher: c_int,
    count: usize,
    header: *mut *mut c_void,
) -> *mut c_void {
    let loan = || {
        let out = port(unsafe { &mut of(door).publishers }, publisher)?;
        out.loan = None;
        let loan = unsafe { out.port.loan_custom_payload(count) }.map_err(why("no room for a message"))?;
        let loan = out.loan.insert(loan);
        if out.has_header {
            unsafe { *header = std::ptr::from_mut(loan.user_header_mut()).cast() };
        }
        Ok(loan.payload_mut().as_mut_ptr().cast())
    };
    tell(null_mut(), loan())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_send(door: *mut Door, publisher: c_int) -> c_int {
    let send = || {
        let out = port(unsafe { &mut of(door).publishers }, publisher)?;
        let loan = out.loan.take().ok_or("nothing was loaned")?;
        let sent = unsafe { loan.assume_init() }.send();
        sent.map(|receivers| receivers as c_int).map_err(why("cannot send"))
    };
    tell(-1, send())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_receive(
    door: *mut Door,
    subscriber: c_int,
    elements: *mut *const c_void,
    count: *mut usize,
    header: *mut *const c_void,
) -> c_int {
    let take = || {
        let from = port(unsafe { &mut of(door).subscribers }, subscriber)?;
        from.held = None;
        let taken = from.port.receive().map_err(why("cannot receive"))?;
        let Some(sample) = taken else { return Ok(0) };
        let sample = from.held.insert(sample);
        unsafe {
            *elements = sample.payload().as_ptr().cast();
            *count = sample.header().number_of_elements() as usize;
            *header = if from.has_header { std::ptr::from_ref(sample.user_header()).cast() } else { null() };
        }
        Ok(1)
    };
    tell(-1, take())
}

/// # Safety
/// `service` is a C string.
unsafe fn bell(node: &Node<ipc::Service>, service: *const c_char) -> Done<event::PortFactory<ipc::Service>> {
    let service = unsafe { text(service) }?;
    let name = ServiceName::new(service).map_err(why(service))?;
    node.service_builder(&name).event().open().map_err(why(service))
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_notifier(door: *mut Door, service: *const c_char) -> c_int {
    let make = || {
        let door = unsafe { of(door) };
        let bell = unsafe { bell(&door.node, service) }?;
        let port = bell.notifier_builder().create().map_err(why("cannot notify"))?;
        Ok(keep(&mut door.notifiers, port))
    };
    tell(-1, make())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_notify(door: *mut Door, notifier: c_int) -> c_int {
    let notify = || {
        let port = port(unsafe { &mut of(door).notifiers }, notifier)?;
        port.notify().map(|_| 0).map_err(why("cannot notify"))
    };
    tell(-1, notify())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_listener(door: *mut Door, service: *const c_char) -> c_int {
    let make = || {
        let door = unsafe { of(door) };
        let bell = unsafe { bell(&door.node, service) }?;
        let port = bell.listener_builder().create().map_err(why("cannot listen"))?;
        Ok(keep(&mut door.listeners, port))
    };
    tell(-1, make())
}

#[unsafe(no_mangle)]
pub unsafe extern "C" fn door_wait(door: *mut Door, listener: c_int, microseconds: u64) -> c_int {
    let wait = || {
        let port = port(unsafe { &mut of(door).listeners }, listener)?;
        match port.timed_wait(|_| (), Duration::from_micros(microseconds)) {
            Ok(_) | Err(ListenerWaitError::InterruptSignal) => Ok(0),
            Err(error) => Err(why("cannot wait")(error)),
        }
    };
    tell(-1, wait())
}
