//! Loops on the threads of the current rayon pool.
//!
//! All of them share one instance of rayon's code. A parallel iterator is several kilobytes of code wherever one stands, so they
//! are for loops that take most of a picture's time, for reductions and for sorts.

use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// Calls `work` with each item.
pub fn for_each<I>(items: I, work: impl Fn(I::Item) + Sync)
where
    I: IntoIterator<IntoIter: ExactSizeIterator + Send>,
{
    let items = items.into_iter();
    let count = items.len();
    let items = Mutex::new(items);
    call(count, &|| {
        let item = items.lock().unwrap_or_else(PoisonError::into_inner).next();
        item.into_iter().for_each(&work);
    });
}

/// The values of each item, in order. Each is a task of its own: they should take longer than a microsecond.
pub fn map<I, T: Send>(items: I, value: impl Fn(I::Item) -> T + Sync) -> Vec<T>
where
    I: IntoIterator<IntoIter: ExactSizeIterator + Send>,
{
    let items = items.into_iter();
    let mut values: Vec<Option<T>> = (0..items.len()).map(|_| None).collect();
    for_each(items.zip(&mut values), |(item, to)| *to = Some(value(item)));
    values.into_iter().flatten().collect()
}

/// The values of the numbers from 0 to `count`, exclusive, many to a task.
pub fn table<T: Copy + Default + Send>(count: usize, value: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut values = vec![T::default(); count];
    update(&mut values, |i, to| *to = value(i));
    values
}

/// Changes each value of a list, by its index, many to a task.
pub fn update<T: Send>(values: &mut [T], change: impl Fn(usize, &mut T) + Sync) {
    let length = task_length(values.len());
    for_each(values.chunks_mut(length).enumerate(), |(task, values)| {
        (task * length..).zip(values).for_each(|(i, value)| change(i, value));
    });
}

/// The number of values for which `is` holds, many to a task.
pub fn count<T: Sync>(values: &[T], is: impl Fn(&T) -> bool + Sync) -> usize {
    let counts = map(values.chunks(task_length(values.len())), |values| {
        values.iter().filter(|value| is(value)).count()
    });
    counts.into_iter().sum()
}

/// The number of values to a task.
pub fn task_length(values: usize) -> usize {
    const LEAST: usize = 1024;
    values.div_ceil(16 * rayon::current_num_threads()).max(LEAST)
}

fn call(count: usize, work: &(dyn Fn() + Sync)) {
    (0..count).into_par_iter().with_max_len(1).for_each(|_| work());
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNTS: [usize; 5] = [0, 1, 1023, 1024, 100_001];

    #[test]
    fn values_stand_in_the_order_of_their_items() {
        for count in COUNTS {
            let expected: Vec<usize> = (0..count).map(|i| i * i).collect();
            assert_eq!(map(0..count, |i| i * i), expected);
            assert_eq!(table(count, |i| i * i), expected);
            let mut values: Vec<usize> = (0..count).collect();
            update(&mut values, |i, value| *value *= i);
            assert_eq!(values, expected);
            assert_eq!(super::count(&values, |v| v % 2 == 1), count / 2);
        }
    }

    #[test]
    fn every_item_is_worked_on_once_with_loops_within_loops() {
        let mut values = vec![0; 10_000];
        for_each(values.chunks_mut(97).enumerate(), |(row, to)| {
            to.copy_from_slice(&map(0..to.len(), |i| row * 97 + i));
        });
        assert_eq!(values, (0..10_000).collect::<Vec<_>>());
    }

    #[test]
    fn a_panic_of_an_item_is_a_panic_of_the_loop() {
        let loop_of = || map(0..100, |i| assert_ne!(i, 50, "item 50"));
        let message = std::panic::catch_unwind(loop_of).unwrap_err();
        assert!(message.downcast::<String>().unwrap().contains("item 50"));
    }
}
