//! Connections that have not shown the secret. They are limited in number and time, so that they take nothing from a page.

use std::{
    collections::VecDeque,
    future::pending,
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

use tokio::{sync::Notify, time::timeout};

/// The most connections without the secret. A further one takes the place of the oldest.
const MAX: usize = 32;

/// The time for showing the secret. The head of a browser's request arrives with its connection.
const PATIENCE: Duration = Duration::from_secs(10);

/// The connections that have not shown the secret, the oldest first.
#[derive(Debug, Default)]
pub struct Visitors(Mutex<VecDeque<Arc<Visitor>>>);

/// A connection.
#[derive(Debug, Default)]
pub struct Visitor {
    is_admitted: AtomicBool,
    loses_place: Notify,
}

impl Visitors {
    pub fn enter(&self) -> Arc<Visitor> {
        let visitor = Arc::<Visitor>::default();
        let mut waiting = self.lock();
        if waiting.len() >= MAX
            && let Some(oldest) = waiting.pop_front()
        {
            oldest.loses_place.notify_one();
        }
        waiting.push_back(Arc::clone(&visitor));
        visitor
    }

    /// Lifts the limits of a connection that has shown the secret.
    pub fn admit(&self, visitor: &Arc<Visitor>) {
        if !visitor.is_admitted.swap(true, Ordering::Relaxed) {
            self.leave(visitor);
        }
    }

    /// Frees the place of a connection.
    pub fn leave(&self, visitor: &Arc<Visitor>) {
        self.lock().retain(|other| !Arc::ptr_eq(other, visitor));
    }

    fn lock(&self) -> MutexGuard<'_, VecDeque<Arc<Visitor>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Visitor {
    /// Waits until the connection must end: its time is over or its place is taken.
    pub async fn expired(&self) {
        let _ = timeout(PATIENCE, self.loses_place.notified()).await;
        if self.is_admitted.load(Ordering::Relaxed) {
            pending().await
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_newcomer_takes_the_place_of_the_oldest_that_was_not_admitted() {
        let visitors = Visitors::default();
        let all: Vec<_> = (0..MAX).map(|_| visitors.enter()).collect();
        visitors.admit(&all[0]);
        visitors.admit(&all[0]);
        visitors.leave(&all[1]);
        let waiting = || visitors.lock().iter().map(Arc::as_ptr).collect::<Vec<_>>();
        assert_eq!(waiting().len(), MAX - 2);
        let newcomers = [(); 3].map(|()| visitors.enter());
        assert_eq!(waiting().len(), MAX);
        assert_eq!(waiting()[0], Arc::as_ptr(&all[3]));
        assert_eq!(waiting()[MAX - 1], Arc::as_ptr(&newcomers[2]));
    }
}
