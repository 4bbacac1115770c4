//! Locks, of which a lost thread may have left some poisoned, and threads.

use std::sync::{Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// Takes a lock; what a lost thread left behind is never used.
pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn read<T>(lock: &RwLock<T>) -> RwLockReadGuard<'_, T> {
    lock.read().unwrap_or_else(PoisonError::into_inner)
}

pub(super) fn write<T>(lock: &RwLock<T>) -> RwLockWriteGuard<'_, T> {
    lock.write().unwrap_or_else(PoisonError::into_inner)
}

/// Without a lock, where nobody else can hold it.
pub(super) fn rwlock_mut<T>(lock: &mut RwLock<T>) -> &mut T {
    lock.get_mut().unwrap_or_else(PoisonError::into_inner)
}

/// Without a lock, where nobody else can hold it.
pub(super) fn mutex_mut<T>(mutex: &mut Mutex<T>) -> &mut T {
    mutex.get_mut().unwrap_or_else(PoisonError::into_inner)
}

/// Runs `task` once per thread, the last on this one.
pub(super) fn on_threads<S: Send>(scratch: &mut [S], task: impl Fn(usize, &mut S) + Sync) {
    let Some((last, rest)) = scratch.split_last_mut() else { return };
    if rest.is_empty() {
        return task(0, last);
    }
    let (here, task) = (rest.len(), &task);
    std::thread::scope(|scope| {
        for (k, own) in rest.iter_mut().enumerate() {
            scope.spawn(move || task(k, own));
        }
        task(here, last);
    });
}
