//! The position and the orientation of a camera.
//!
//! A camera's own space is right-handed: it looks along its -z, +y is the top of the picture, +x
//! the right of it. Poses are kept in double precision, so that a step between two frames far from
//! the origin is not lost.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use serde::Serialize;

use crate::{kind::named, math::transform::axis_rotation};

/// The sine of the angle between `up` and the line of sight below which the two count as parallel.
const PARALLEL: f64 = 1e-6;

/// Why there is no such pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PoseError {
    #[error("the target is at the eye")]
    TargetAtEye,
    #[error("the quaternion has length 0")]
    ZeroQuaternion,
    #[error("a number is not finite")]
    NotFinite,
}

/// An eye point and a right-handed orthonormal frame, in world space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pose {
    eye: DVec3,
    /// The camera's x (right), y (up) and z (back) axes as columns: the rotation from camera to
    /// world.
    axes: DMat3,
}

/// The orientation of a camera towards a target.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookAt {
    /// The point in the middle of the picture, in world space, m.
    pub target: DVec3,
    /// The direction that appears upwards in the picture. It has any length and need not be
    /// perpendicular to the line of sight.
    pub up: DVec3,
    /// Turn about the line of sight, in degrees; positive turns the camera counter-clockwise as
    /// seen from behind it, as a positive `rot_z` does, so that the picture's content turns
    /// clockwise.
    pub roll: f64,
}

impl LookAt {
    /// Upright, with +y upwards.
    pub fn new(target: DVec3) -> Self {
        let (up, roll) = (DVec3::Y, 0.0);
        Self { target, up, roll }
    }
}

impl Pose {
    /// The pose at `eye` that looks along -z with +y up.
    pub fn at(eye: DVec3) -> Self {
        Self {
            eye,
            axes: DMat3::IDENTITY,
        }
    }

    /// The pose at `eye` (m) that looks at a target.
    ///
    /// If `up` is parallel to the line of sight, or has length 0, the camera is turned as if it had
    /// looked ahead and had then been pitched up or down: ahead is -z, or +y if the line of sight is
    /// nearer to the z axis than to the others. A camera that looks straight down in a y-up world thus
    /// has -z at the top of its picture, and in a z-up world +y.
    ///
    /// # Errors
    /// The target is at the eye, or a number is not finite.
    pub fn look_at(eye: DVec3, at: &LookAt) -> Result<Self, PoseError> {
        if !(eye.is_finite() && at.target.is_finite() && at.up.is_finite() && at.roll.is_finite()) {
            return Err(PoseError::NotFinite);
        }
        let forward = unit(at.target - eye).ok_or(PoseError::TargetAtEye)?;
        let up = unit(at.up).filter(|up| forward.cross(*up).length() > PARALLEL);
        let up = up.unwrap_or_else(|| up_when_parallel(forward, at.up));
        let cross = forward.cross(up);
        let right = cross / cross.length();
        let axes = DMat3::from_cols(right, right.cross(forward), -forward);
        Ok(Self {
            eye,
            axes: if at.roll == 0.0 {
                axes
            } else {
                axes * axis_rotation(2, at.roll)
            },
        })
    }

    /// The pose at `eye` (m) with a rotation from camera to world; the quaternion is normalized.
    ///
    /// # Errors
    /// The quaternion has length 0, or a number is not finite.
    pub fn from_quaternion(eye: DVec3, camera_to_world: DQuat) -> Result<Self, PoseError> {
        if !(eye.is_finite() && camera_to_world.is_finite()) {
            return Err(PoseError::NotFinite);
        }
        let length = camera_to_world.length();
        if length == 0.0 {
            return Err(PoseError::ZeroQuaternion);
        }
        let axes = DMat3::from_quat(camera_to_world / length);
        Ok(Self { eye, axes })
    }

    /// The pose at `eye` (m) turned from the one that looks along -z by three angles in degrees,
    /// one for each coordinate axis, in the order of [`RotationOrder`].
    ///
    /// # Errors
    /// A number is not finite.
    pub fn from_euler(eye: DVec3, degrees: DVec3, order: RotationOrder) -> Result<Self, PoseError> {
        if !(eye.is_finite() && degrees.is_finite()) {
            return Err(PoseError::NotFinite);
        }
        let axes = order.rotation(degrees);
        Ok(Self { eye, axes })
    }

    /// The eye point, in m.
    pub fn eye(&self) -> DVec3 {
        self.eye
    }

    /// The unit vector to the right of the picture.
    pub fn right(&self) -> DVec3 {
        self.axes.x_axis
    }

    /// The unit vector to the top of the picture.
    pub fn up(&self) -> DVec3 {
        self.axes.y_axis
    }

    /// The unit vector along the line of sight.
    pub fn forward(&self) -> DVec3 {
        -self.axes.z_axis
    }

    /// A vector of camera space in world space.
    pub fn vector_to_world(&self, v: DVec3) -> DVec3 {
        self.axes * v
    }

    /// The map from camera to world.
    pub fn world_from_camera(&self) -> DAffine3 {
        DAffine3 {
            matrix3: self.axes,
            translation: self.eye,
        }
    }
}

/// `v` at unit length; `None` for a vector without a direction. Divides, so that an axis stays
/// exactly an axis.
fn unit(v: DVec3) -> Option<DVec3> {
    let length = v.length();
    (length > 0.0 && length.is_finite()).then(|| v / length)
}

fn up_when_parallel(forward: DVec3, up: DVec3) -> DVec3 {
    let along = forward.abs();
    let ahead = if along.z > along.x && along.z > along.y {
        DVec3::Y
    } else {
        DVec3::NEG_Z
    };
    // Looking up, the way ahead is behind the head.
    if forward.dot(up) > 0.0 { -ahead } else { ahead }
}

named! {
    /// The order in which the angles about x, y and z are applied, read from left to right, each about
    /// the *fixed* world axis: `ZXY` turns about z first, then about x, then about y, so that a column
    /// vector is mapped by `Ry Rx Rz`. This is what `rot_order` of a Nuke camera and `rotateOrder` of
    /// Maya mean. (The same rotation is y, then the turned x, then the turned z about *moving* axes.)
    pub enum RotationOrder: "rotation order" ignoring case {
        Xyz = "XYZ",
        Xzy = "XZY",
        Yxz = "YXZ",
        Yzx = "YZX",
        Zxy = "ZXY",
        Zyx = "ZYX",
    }
}

impl RotationOrder {
    /// The axes, 0 for x, in the order in which they are turned about.
    pub const fn axes(self) -> [usize; 3] {
        match self {
            Self::Xyz => [0, 1, 2],
            Self::Xzy => [0, 2, 1],
            Self::Yxz => [1, 0, 2],
            Self::Yzx => [1, 2, 0],
            Self::Zxy => [2, 0, 1],
            Self::Zyx => [2, 1, 0],
        }
    }

    /// The rotation by `degrees.x` about x, and so on, in this order. Exact at multiples of 90
    /// degrees.
    pub fn rotation(self, degrees: DVec3) -> DMat3 {
        self.axes().into_iter().fold(DMat3::IDENTITY, |before, axis| {
            axis_rotation(axis, degrees[axis]) * before
        })
    }

    /// The angles about x, y and z, in degrees, of which [`RotationOrder::rotation`] makes `axes`, a rotation. That about the
    /// second axis lies between -90 and 90; where it is either, the angle about the first axis is 0.
    pub fn angles(self, axes: &DMat3) -> DVec3 {
        // About moving axes the order is reversed: first i, then j, then k.
        let [k, j, i] = self.axes();
        let m = |row: usize, column: usize| axes.col(column)[row];
        let sign = if (i + 1) % 3 == j { 1.0 } else { -1.0 };
        let cos = m(i, i).hypot(m(i, j));
        // Exact near 90 degrees too, where the arc sine is not.
        let middle = libm::atan2(sign * m(i, k), cos);
        let (outer, inner) = if cos > 1e-9 {
            (
                libm::atan2(-sign * m(j, k), m(k, k)),
                libm::atan2(-sign * m(i, j), m(i, i)),
            )
        } else {
            (libm::atan2(sign * m(k, j), m(j, j)), 0.0)
        };
        let mut angles = DVec3::ZERO;
        for (axis, radians) in [(i, outer), (j, middle), (k, inner)] {
            angles[axis] = radians.to_degrees();
        }
        angles
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn look(eye: DVec3, target: DVec3, up: DVec3, roll: f64) -> Result<Pose, PoseError> {
        Pose::look_at(eye, &LookAt { target, up, roll })
    }

    fn assert_orthonormal(pose: &Pose) {
        assert!((pose.right().cross(pose.up()) + pose.forward()).length() < 1e-12);
        assert!((pose.right().length() - 1.0).abs() < 1e-12 && (pose.up().length() - 1.0).abs() < 1e-12);
        assert!(pose.right().dot(pose.up()).abs() < 1e-12);
    }

    #[test]
    fn looking_along_minus_z_is_the_identity() {
        let eye = DVec3::new(0.0, 0.0, 15.0);
        assert_eq!(look(eye, DVec3::ZERO, DVec3::Y, 0.0), Ok(Pose::at(eye)));
        assert_eq!(Pose::from_quaternion(eye, DQuat::IDENTITY), Ok(Pose::at(eye)));
        assert_eq!(
            Pose::from_euler(eye, DVec3::ZERO, RotationOrder::Zxy),
            Ok(Pose::at(eye))
        );
    }

    #[test]
    fn a_target_at_the_eye_gives_no_pose() {
        assert_eq!(look(DVec3::ONE, DVec3::ONE, DVec3::Y, 0.0), Err(PoseError::TargetAtEye));
    }

    #[test]
    fn up_along_the_line_of_sight_is_as_if_pitched_from_looking_ahead() {
        let top = |target: DVec3, up| look(DVec3::ZERO, target, up, 0.0).expect("a pose").up();
        assert_eq!(top(DVec3::NEG_Y, DVec3::Y), DVec3::NEG_Z);
        assert_eq!(top(DVec3::Y, DVec3::Y), DVec3::Z);
        assert_eq!(top(DVec3::NEG_Z, DVec3::Z), DVec3::Y);
        assert_eq!(top(DVec3::Z, DVec3::Z), DVec3::NEG_Y);
        assert_eq!(top(DVec3::NEG_Y, DVec3::ZERO), DVec3::NEG_Z);
    }

    #[test]
    fn a_positive_roll_turns_the_camera_counter_clockwise_seen_from_behind() {
        let pose = look(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 90.0).expect("a pose");
        assert_eq!((pose.right(), pose.up()), (DVec3::Y, DVec3::NEG_X));
        let same = Pose::from_euler(DVec3::ZERO, DVec3::new(0.0, 0.0, 90.0), RotationOrder::Xyz);
        assert_eq!(same, Ok(pose));
    }

    #[test]
    fn zxy_turns_about_fixed_z_then_x_then_y() {
        let degrees = DVec3::new(10.0, 20.0, 30.0);
        let m = |axis: usize| axis_rotation(axis, degrees[axis]);
        let want = m(1) * m(0) * m(2);
        assert_eq!(RotationOrder::Zxy.rotation(degrees), want);
        // 90 about z takes +x to +y, then 90 about x takes +y to +z, and 0 about y leaves it.
        let turned = RotationOrder::Zxy.rotation(DVec3::new(90.0, 0.0, 90.0)) * DVec3::X;
        assert_eq!(turned, DVec3::Z);
        // XYZ: x leaves +x, then z takes it to +y.
        let turned = RotationOrder::Xyz.rotation(DVec3::new(90.0, 0.0, 90.0)) * DVec3::X;
        assert_eq!(turned, DVec3::Y);
    }

    #[test]
    fn the_angles_of_a_rotation_make_it_again() {
        for order in RotationOrder::ALL {
            for degrees in [
                [10.0, 20.0, 30.0],
                [-170.0, 60.0, 95.0],
                [90.0, -45.0, 0.0],
                [0.0, 90.0, 30.0],
                [20.0, 5.0, -90.0],
            ] {
                let rotation = order.rotation(DVec3::from_array(degrees));
                let again = order.rotation(order.angles(&rotation));
                assert!(again.abs_diff_eq(rotation, 1e-9), "{order} {degrees:?}");
            }
        }
    }

    #[test]
    fn orders_are_read_in_any_case_and_others_are_named() {
        for order in RotationOrder::ALL {
            assert_eq!(order.to_string().to_lowercase().parse(), Ok(order));
        }
        assert_eq!(
            "ZXX".parse::<RotationOrder>().unwrap_err().to_string(),
            "unknown rotation order `ZXX` (did you mean `ZXY`?)"
        );
    }

    #[test]
    fn a_quaternion_maps_camera_to_world() {
        // 90 degrees about +y: the camera that looked along -z looks along -x.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let pose = Pose::from_quaternion(DVec3::ZERO, DQuat::from_xyzw(0.0, half, 0.0, half)).expect("a pose");
        assert!((pose.forward() - DVec3::NEG_X).length() < 1e-15);
        assert_eq!(
            Pose::from_quaternion(DVec3::ZERO, DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
            Err(PoseError::ZeroQuaternion)
        );
    }

    fn point() -> impl Strategy<Value = DVec3> {
        [-100.0..100.0, -100.0..100.0, -100.0..100.0].prop_map(|[x, y, z]: [f64; 3]| DVec3::new(x, y, z))
    }

    proptest! {
        #[test]
        fn frames_are_orthonormal_whatever_is_looked_at(eye in point(), target in point(), up in point(), roll in -400.0..400.0) {
            let pose = look(eye, target, up, roll).unwrap();
            assert_orthonormal(&pose);
            prop_assert!((pose.forward() - (target - eye).normalize()).length() < 1e-12);
            // Straight up and down too.
            assert_orthonormal(&look(eye, target, target - eye, roll).unwrap());
            assert_orthonormal(&look(eye, target, eye - target, roll).unwrap());
        }

        #[test]
        fn frames_of_angles_are_orthonormal(degrees in point(), i in 0_usize..6) {
            assert_orthonormal(&Pose::from_euler(DVec3::ZERO, degrees, RotationOrder::ALL[i]).unwrap());
        }
    }
}
