//! Numbers in JSON. A missing or invalid number has its default.

use ::gltf::json::Value;

/// The number of `key`.
pub(super) fn number(value: &Value, key: &str, default: f32) -> f32 {
    finite(value.get(key)).unwrap_or(default)
}

/// The number of `key`, from 0 to 1.
pub(super) fn unit(value: &Value, key: &str, default: f32) -> f32 {
    number(value, key, default).clamp(0.0, 1.0)
}

/// The numbers of `key`.
pub(super) fn numbers<const N: usize>(value: &Value, key: &str, default: [f32; N]) -> [f32; N] {
    let given = value.get(key);
    std::array::from_fn(|i| finite(given.and_then(|v| v.get(i))).unwrap_or(default[i]))
}

/// The numbers of `key` in double precision.
pub(super) fn doubles<const N: usize>(value: &Value, key: &str, default: [f64; N]) -> [f64; N] {
    let given = value.get(key);
    let number = |i: usize| given?.get(i)?.as_f64().filter(|v| v.is_finite());
    std::array::from_fn(|i| number(i).unwrap_or(default[i]))
}

/// The index of `key`; `None` where there is none.
pub(super) fn index(value: &Value, key: &str) -> Option<usize> {
    usize::try_from(value.get(key)?.as_u64()?).ok()
}

fn finite(value: Option<&Value>) -> Option<f32> {
    let number = value?.as_f64()? as f32;
    number.is_finite().then_some(number)
}
