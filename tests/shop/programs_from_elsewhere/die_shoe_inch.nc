o2002(surface grind die shoe inch)
g70g90g94g19
g54
s1800m3
m8
g0x-1.5z0.
y.05
g1y0.f10.


(rough)
g83x9.5i-1.5y-.008j-.001z1.5k.25l0f20.e600.p9010d2


(finish)
g83y-.0095j-.0003k.08l2f20.e480.d1

g80
g0y3.
m9
m5
m30

o9010
g90g0y4.
x-6.
z-1.
g91g1y-.001f2.
g90
z2.f10.
g0y4.1
z0.
m99