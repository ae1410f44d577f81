"""Where the numbers come from: the public source behind each code that a row carries."""

from __future__ import annotations

SOURCES: dict[str, str] = {
    "L6": "Aldebaran documentation 2.8, NAO6 links: doc.aldebaran.com/2-8/family/nao_technical/links_naov6.html",
    "L33": "Aldebaran documentation 2.5, H25 V3.3 links: family/nao_h25/links_h25_v33.html",
    "L32": "Aldebaran documentation 2.5, V3.2 links: family/robots/links_robot_v32.html",
    "J6": "Aldebaran documentation 2.8, NAO6 joints: doc.aldebaran.com/2-8/family/nao_technical/joints_naov6.html",
    "J32": "Aldebaran documentation 2.4, V3.2 joints: doc.aldebaran.com/2-4/family/nao_h21/joints_h21_v32.html",
    "BP6": "Aldebaran documentation 2.8, NAO6 body parts: doc.aldebaran.com/2-8/family/nao_technical/bodyparts_naov6.html",
    "U6": "official URDF NAOH25V60 as published in HULKs/hulk, webots/protos/NAO.urdf",
    "U5": "official URDF NAOH25V50 as published in ros-naoqi/nao_robot, nao_description/urdf/naoV50_generated_urdf",
    "U4": "official URDF NAOH25V40 as published in ros-naoqi/nao_robot, nao_description/urdf/naoV40_generated_urdf",
    "U33": "official URDF NAOH25V33 as published in ros-naoqi/nao_robot, nao_description/urdf/naoV33_generated_urdf",
    "U32": "official URDF NAOH25V32 as published in ros-naoqi/nao_robot, nao_description/urdf/naoV32_generated_urdf",
    "QB": "softbankrobotics-research/qibullet, qibullet/robot_posture.py (Apache-2.0)",
    "MIM": "ALMotion.getPosition recordings of LennonNM/NaoMimic: the foot height that makes both feet fit one HipYawPitch",
    "GEN": "drawn for this library",
}
