// polyhedron sweep: rope-like torus knot tube
n=120; m=12; function P(t)=[ (2+cos(3*t))*cos(2*t)*6, (2+cos(3*t))*sin(2*t)*6, sin(3*t)*6 ];
function T(t)=let(d=P(t+1)-P(t-1)) d/norm(d);
function N(t)=let(c=cross(T(t),[0,0,1])) c/norm(c);
pts=[for(i=[0:n-1]) let(t=360*i/n,a=N(t),b=cross(T(t),a)) for(j=[0:m-1]) P(t)+1.8*(cos(360*j/m)*a+sin(360*j/m)*b)];
faces=[for(i=[0:n-1],j=[0:m-1]) [i*m+j,i*m+(j+1)%m,((i+1)%n)*m+(j+1)%m,((i+1)%n)*m+j]];
polyhedron(pts,[for(f=faces) [f[3],f[2],f[1],f[0]]]);
