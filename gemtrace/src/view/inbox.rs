//! What waits to be done: the newest of each gesture, in order.

use super::hub::{Client, locked};
use super::message::{Change, Letter, Refusal};
use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use tokio::sync::oneshot;

/// The most that waits; then the page is told that it asks too fast.
const MOST: usize = 1000;

/// Something that changes what is shown.
pub enum Order {
    Change(Arc<Client>, Change),
    /// Device pixels of one view.
    Size([u32; 2]),
    /// A file that was dropped; without a side it is opened in place of what is there.
    Dropped {
        path: PathBuf,
        side: Option<Letter>,
        reply: oneshot::Sender<Result<(), Refusal>>,
    },
}

#[derive(Default)]
pub struct Inbox {
    orders: Mutex<VecDeque<Order>>,
    news: Condvar,
}

impl Inbox {
    /// Adds an order; returns whether there was room. Of a gesture that goes on only the newest counts.
    pub fn put(&self, order: Order) -> bool {
        let mut orders = locked(&self.orders);
        if orders.back().is_some_and(|last| is_overtaken(last, &order)) {
            orders.pop_back();
        }
        if orders.len() == MOST {
            return false;
        }
        orders.push_back(order);
        self.news.notify_all();
        true
    }

    /// Whether something waits.
    pub fn is_waiting(&self) -> bool {
        !locked(&self.orders).is_empty()
    }

    /// All that waits.
    pub fn take(&self) -> VecDeque<Order> {
        std::mem::take(&mut locked(&self.orders))
    }

    /// Waits until something waits.
    pub fn wait(&self) {
        let orders = locked(&self.orders);
        drop(
            self.news.wait_while(orders, |orders| orders.is_empty()).unwrap_or_else(PoisonError::into_inner),
        );
    }
}

/// Whether the next order of a gesture makes the last one needless.
fn is_overtaken(last: &Order, next: &Order) -> bool {
    match (last, next) {
        (Order::Size(_), Order::Size(_)) => true,
        (Order::Change(_, last), Order::Change(_, next)) => match (last, next) {
            (Change::Pose { done: false, .. }, Change::Pose { .. })
            | (Change::Lights { done: false, .. }, Change::Lights { .. })
            | (Change::Distance { done: false, .. }, Change::Distance { .. }) => true,
            (Change::Set { path: a, side: on, done: false, .. }, Change::Set { path: b, side, .. }) => {
                (a, on) == (b, side)
            }
            _ => false,
        },
        _ => false,
    }
}
